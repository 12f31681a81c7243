// SPDX-License-Identifier: Apache-2.0
// A drive of each of three kinds; the command wire_faults makes five of every kind.
#include "system/wire_faults.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace tandem::test {
namespace {

class WireFaults : public testing::TestWithParam<const char*> {};

TEST_P(WireFaults, TouchNothingAndAreNamedWhereTheRobotStands) {
  const auto& all = wire_faults();
  const auto fault = std::ranges::find(all, std::string{GetParam()}, &WireFault::name);
  ASSERT_NE(fault, all.end());
  WireDrive drive{1, *fault};
  drive.run();
  EXPECT_EQ(drive.contacts(), 0U);
  EXPECT_TRUE(drive.is_as_wanted()) << drive.travelled() << " m: " << drive.reasons();
}

// What these drives would show if a frame were not heeded.
TEST(WireDrive, WouldBeFeltByARobotThatBelievedTheMapsNumbers) {
  WireDrive drive{2, {.name = "a map that lies", .map_lies = true}};
  drive.run();
  EXPECT_GT(drive.contacts(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Kinds, WireFaults,
                         testing::Values("map in odom", "scanner 2 s late", "odom best effort"),
                         [](const auto& test) {
                           std::string name{test.param};
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace tandem::test
