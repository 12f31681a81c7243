// SPDX-License-Identifier: Apache-2.0
// Runs one drive of each link and fault; `link_faults` runs any number.
#include "closed_loop/link_faults.hpp"

#include <gtest/gtest.h>

namespace tandem::test {
namespace {

class LinkFaults : public testing::TestWithParam<unsigned> {};

TEST_P(LinkFaults, TouchNothing) {
  Lockstep lockstep;
  const LinkDrive drive = link_drive(GetParam());
  EXPECT_EQ(drive_with_fault(lockstep, drive).collisions, 0)
      << name(drive.fault) << " of " << drive.link;
}

INSTANTIATE_TEST_SUITE_P(Each, LinkFaults,
                         testing::Range(0U, static_cast<unsigned>(links().size() *
                                                                  std::size(kLinkFaults))));

}  // namespace
}  // namespace tandem::test
