// SPDX-License-Identifier: Apache-2.0
// Drives once with each of three kinds of fault; the command wire_faults drives five times with
// every kind.
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

// Control test: a robot that ignored frames would fail these drives.
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
