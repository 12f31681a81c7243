// SPDX-License-Identifier: Apache-2.0
// Tests the builder's reports on its sensors.
#include <algorithm>
#include <limits>

#include "system/builder_over_dds.hpp"

namespace tandem::test {
namespace {

TEST_F(BuilderOverDds, ReportsSensorStatusFromTheStartEvenWithoutSensors) {
  ASSERT_TRUE(wait_until([&] { return says("no data on scan or cloud_in"); }));
  ASSERT_TRUE(wait_for_maps(1));
  ASSERT_TRUE(wait_until([&] { return says("scan is silent"); }));
  EXPECT_EQ(code_, Reason::kSensorSilent);
  const long before = statuses_;
  const double began = node_.steady_now();
  ASSERT_TRUE(wait_until([&] { return statuses_ >= before + 20; }));
  EXPECT_LT(node_.steady_now() - began, 4.0);  // 5 Hz
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
  EXPECT_EQ(code_, Reason::kNone);
}

TEST_F(BuilderOverDds, ABlindScannerIsNamedBesideACameraThatSees) {
  const auto camera = camera_that_sees(true);
  for (const float nothing : {0.0F, std::numeric_limits<float>::quiet_NaN()}) {
    ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
    const auto blind = [&](auto& msg) { msg.ranges().assign(360, nothing); };
    ASSERT_TRUE(wait_with_scans(blind, [&] { return says("scan gives no valid range"); }));
    EXPECT_TRUE(says("no_return"));
  }
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
  ASSERT_TRUE(wait_with_scans([](auto& msg) { msg.ranges().clear(); },
                              [&] { return says("scan gives no valid range (no beams)"); }));
  const long before = maps_;
  EXPECT_TRUE(wait_until([&] { return maps_ > before; }));  // by the camera
  EXPECT_GT(log_.lines("the robot must stand still: scan gives no valid range"), 0);
}

TEST_F(BuilderOverDds, ADeadCameraIsNamedBesideAScannerThatSees) {
  auto camera = camera_that_sees(true);
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
  camera = {};
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says("cloud_in is silent"); }));
  camera = camera_that_sees(true);
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
}

TEST_F(BuilderOverDds, ACameraThatSeesNothingClearsAndStopsNothing) {
  const auto camera = camera_that_sees(false);
  ASSERT_TRUE(wait_for_maps(1));
  // Nothing is reported for three times sensor_timeout. A stall of this process, which is odometry
  // and the sensors as well, is reported rightly; the time then begins anew.
  double quiet_since = node_.steady_now();
  EXPECT_TRUE(wait_with_scans([](auto&) {},
                              [&] {
                                if (!says("")) quiet_since = node_.steady_now();
                                return node_.steady_now() > quiet_since + 1.5;
                              }))
      << *reason_;
  EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
}

TEST_F(BuilderOverDds, AScannerThatReportsItsFarthestReadingAsRangeMaxShowsAWall) {
  const long before = maps_;
  ASSERT_TRUE(
      wait_with_scans([](auto& msg) { msg.range_max(3.0F); }, [&] { return maps_ > before + 2; }));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
  EXPECT_TRUE(wait_until([&] { return says(""); }));
}

TEST_F(BuilderOverDds, NothingInRangeIsAskedForByItsName) {
  const auto mostly_zero = [](auto& msg) {
    std::fill(msg.ranges().begin() + 100, msg.ranges().end(), 0.0F);
  };
  EXPECT_TRUE(wait_with_scans(mostly_zero, [&] {
    return log_.lines("most beams have been zero") == 1 && log_.lines("parameter no_return") == 1;
  }));
}

TEST_F(BuilderOverDds, ReturnsFromTheRobotItselfAreNotObstacles) {
  const auto posts = [](auto& msg) {
    for (std::size_t i = 0; i < 10; ++i) msg.ranges()[i] = 0.3F;
  };
  const long before = maps_;
  ASSERT_TRUE(wait_with_scans(posts, [&] { return maps_ > before + 5; }));
  EXPECT_FALSE(is_occupied(kRobotOnMap.x + 0.01, kRobotOnMap.y + 0.301));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x, kRobotOnMap.y - 3.001));
  EXPECT_EQ(log_.lines("scan: 10 returns of one measurement lie inside the robot's outline"), 1);
}

TEST_F(BuilderOverDds, InfiniteRangeMaxAndAnOddTimeIncrementAreAccepted) {
  const auto odd = [](auto& msg) {
    msg.range_max(std::numeric_limits<float>::infinity());
    msg.time_increment(153333.0F);
  };
  const long before = maps_;
  ASSERT_TRUE(wait_with_scans(odd, [&] { return maps_ > before + 2; }));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
  EXPECT_EQ(log_.lines("scan: time_increment = 153333 s"), 1);
}

TEST_F(BuilderOverDds, ASensorsClockThatIsOffIsNamed) {
  ASSERT_TRUE(wait_for_maps(1));
  const auto late = [](auto& msg) { msg.header().stamp().sec(msg.header().stamp().sec() - 3); };
  EXPECT_TRUE(wait_with_scans(late, [&] { return says("its stamp is 3.0 s behind odometry's"); }));
  const auto early = [](auto& msg) { msg.header().stamp().sec(msg.header().stamp().sec() + 3); };
  EXPECT_TRUE(wait_with_scans(early, [&] { return says("s ahead of odometry's"); }));
}

TEST_F(BuilderOverDds, AFrozenScannerIsNamedOnceTheWheelsHaveMoved) {
  auto same = scan(2.0F);  // one side of a room, and another
  std::fill(same.ranges().begin(), same.ranges().begin() + 180, 3.0F);
  const auto freeze = [&](auto& msg) { msg.ranges(same.ranges()); };
  ASSERT_TRUE(wait_with_scans(freeze, [&] { return says(""); }));
  const auto drive = node_.create_wall_timer(0.02, [this] { robot_.y += 0.002; });
  EXPECT_TRUE(wait_with_scans(freeze, [&] { return says("scan is frozen"); }));
  EXPECT_GT(robot_.y, kRobotOnMap.y + 0.1);
  EXPECT_FALSE(is_occupied(kRobotOnMap.x, kRobotOnMap.y - 2.001 + 0.1));  // not carried along
}

class BuilderThatNeedsACamera : public BuilderOverDds {
 protected:
  BuilderThatNeedsACamera() : BuilderOverDds{{{"required_sensors", "[cloud_in]"}}} {}
};

TEST_F(BuilderThatNeedsACamera, NamesItUntilItDelivers) {
  ASSERT_TRUE(wait_with_scans(
      [](auto&) {}, [&] { return says("cloud_in is silent, and required_sensors names it"); }));
  const auto camera = camera_that_sees(false);
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
}

class BuilderOfADriverThatSendsRangeMax : public BuilderOverDds {
 protected:
  BuilderOfADriverThatSendsRangeMax() : BuilderOverDds{{{"no_return", "[range_max, nan]"}}} {}
};

TEST_F(BuilderOfADriverThatSendsRangeMax, RefusesARangeMaxThatVaries) {
  const auto hall = [](auto& msg) { msg.ranges().assign(360, msg.range_max()); };
  ASSERT_TRUE(wait_with_scans(hall, [&] { return maps_ > 0 && says(""); }));
  const auto other = [](auto& msg) { msg.range_max(3.0F); };
  EXPECT_TRUE(
      wait_with_scans(other, [&] { return says("scan is refused: its range_max varies"); }));
}

}  // namespace
}  // namespace tandem::test
