// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/nearest_name.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace tandem {
namespace {

const std::set<std::string> kNames{"a_brake", "alpha_brake", "margin", "width"};

TEST(NearestName, CountsChangedLetters) {
  EXPECT_EQ(letters_apart("leadr", "leader"), 1U);
  EXPECT_EQ(letters_apart("", "abc"), 3U);
}

TEST(NearestName, ToleratesAFewWrongLetters) {
  EXPECT_EQ(nearest_name("a_brk", kNames), "a_brake");
  EXPECT_EQ(nearest_name("widht", kNames), "width");
  EXPECT_EQ(nearest_name("alfa_brake", kNames), "alpha_brake");
}

TEST(NearestName, IsEmptyIfNoneIsClose) {
  EXPECT_EQ(nearest_name("height", kNames), "");
  EXPECT_EQ(nearest_name("margin", std::set<std::string>{}), "");
}

TEST(NearestName, MakesAQuestion) {
  EXPECT_EQ(did_you_mean("margn", kNames), "; did you mean `margin`?");
  EXPECT_EQ(did_you_mean("height", kNames), "");
}

}  // namespace
}  // namespace tandem
