// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/nearest_name.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

const std::set<std::string> kNames{"a_brake", "alpha_brake", "margin", "width"};

TEST(NearestName, ToleratesAFewWrongLetters) {
  EXPECT_EQ(nearest_name("a_brk", kNames), "a_brake");
  EXPECT_EQ(nearest_name("widht", kNames), "width");
  EXPECT_EQ(nearest_name("alfa_brake", kNames), "alpha_brake");
}

TEST(NearestName, IsEmptyIfNoneIsClose) {
  EXPECT_EQ(nearest_name("height", kNames), "");
  EXPECT_EQ(nearest_name("margin", {}), "");
}

TEST(NearestName, MakesAQuestion) {
  EXPECT_EQ(did_you_mean("margn", kNames), "; did you mean `margin`?");
  EXPECT_EQ(did_you_mean("height", kNames), "");
}

}  // namespace
}  // namespace tandem
