// SPDX-License-Identifier: Apache-2.0
// Runs a few drives with each fault; `sensing_faults` runs any number.
#include "closed_loop/sensing_faults.hpp"

#include <gtest/gtest.h>

#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

class SensingFaults : public testing::TestWithParam<SensingFault> {};

TEST_P(SensingFaults, TouchNothingAndAreNamed) {
  double travelled = 0.0;
  const unsigned kDrives = samples(2, 1, 8);
  for (unsigned seed = 1; seed <= kDrives; ++seed) {
    FaultyDrive drive{seed, GetParam()};
    drive.run();
    EXPECT_EQ(drive.contacts(), 0u) << seed;
    EXPECT_TRUE(drive.is_named()) << seed << ": " << drive.said();
    travelled += drive.travelled();
  }
  if (*GetParam().reason == '\0') {
    EXPECT_GT(travelled, 0.5 * kDrives);  // [m] what is harmless does not stop the robot
  }
}

INSTANTIATE_TEST_SUITE_P(All, SensingFaults, testing::ValuesIn(sensing_faults()),
                         [](const auto& tested) { return std::string{tested.param.name}; });

}  // namespace
}  // namespace tandem::test
