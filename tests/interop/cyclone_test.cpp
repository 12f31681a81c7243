// SPDX-License-Identifier: Apache-2.0
// A Cyclone DDS program drives our robot: it publishes cmd_vel_user and reads odom and cmd_vel.
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/child_process.hpp"
#include "support/private_domain.hpp"

namespace tandem {
namespace {

TEST(CyclonePeer, DrivesOurRobotAndReadsItsOdometry) {
  // Policy manual behind the filter: the peer's Twist is the person's command.
  test::ChildProcess robot{"../tandem",
                           {"run", TANDEM_SOURCE_DIR "/bringup/systems/teleop.yaml", "--ros-args",
                            "-p", "arbitration:policy:=manual"}};
  test::ChildProcess peer{"cyclone_peer", {std::getenv("ROS_DOMAIN_ID"), "0.3", "0.0", "60"}};
  EXPECT_EQ(peer.wait(70.0), 0);
  robot.send(SIGTERM);
  EXPECT_EQ(robot.wait(5.0), 0);
}

}  // namespace
}  // namespace tandem
