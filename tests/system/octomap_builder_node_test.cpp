// SPDX-License-Identifier: Apache-2.0
// Tests how the builder processes scans and clouds.
#include <numbers>
#include <random>
#include <utility>

#include "support/instrumented.hpp"
#include "system/builder_over_dds.hpp"

namespace tandem::test {
namespace {

constexpr unsigned kNoise = samples(100'000, 10'000);  // points

TEST_F(BuilderOverDds, ShowsWhatAScanSeesWhereTheRobotIs) {
  ASSERT_TRUE(wait_for_maps(2));
  EXPECT_EQ(frame_, "map");
  for (int i = 0; i < 12; ++i) {
    const double angle = kBeamTurn * 30.0 * i;
    EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001 * std::cos(angle),
                            kRobotOnMap.y + 3.001 * std::sin(angle)))
        << i;
    EXPECT_FALSE(
        is_occupied(kRobotOnMap.x + 2.5 * std::cos(angle), kRobotOnMap.y + 2.5 * std::sin(angle)))
        << i;
  }
}

// A scanner that sees only forward, on the left of the map.
TEST_F(BuilderOverDds, CoversWhatItsBeamsPassAndWhereItsOutlineStandsAndNothingElse) {
  const auto is_known = [&](double x, double y, double z) {
    return tree_->search(kRobotOnMap.x + x, kRobotOnMap.y + y, z) != nullptr;
  };
  auto ahead = scan(3.0F);
  ahead.angle_min(-1.0F);
  ahead.ranges().resize(115);
  const auto beat = node_.create_wall_timer(0.05, [&] {
    ahead.header().stamp(node_.stamp());
    scan_.publish(ahead);
  });
  ASSERT_TRUE(wait_until([&] { return maps_ > 0 && is_known(0.0, -0.3, 0.125); }));
  EXPECT_TRUE(is_known(0.0, 2.0, 0.3));
  EXPECT_FALSE(is_known(0.0, -0.3, 0.3));
  for (const double z : {0.125, 0.3}) EXPECT_FALSE(is_known(0.0, -1.0, z)) << "behind it";
  EXPECT_FALSE(is_known(0.0, 3.3, 0.3)) << "behind the return";
}

TEST_F(BuilderOverDds, IsSilentWithoutScans) {
  ASSERT_TRUE(wait_for_maps(1));
  // Maps may be under way yet.
  long heard = maps_;
  double last = node_.steady_now();
  EXPECT_TRUE(wait_until([&] {
    if (maps_ != std::exchange(heard, maps_)) last = node_.steady_now();
    return node_.steady_now() > last + 0.5;
  }));
}

TEST_F(BuilderOverDds, MalformedScansAndCloudsAreRefusedWithOneLineAndNothingIsLost) {
  ASSERT_TRUE(wait_for_maps(1));
  auto bad_scan = scan(1.0F);
  bad_scan.angle_increment(static_cast<float>(kNaN));
  sensor_msgs::msg::PointCloud2 bad_cloud;
  bad_cloud.header(header(node_.stamp(), "base_link"));
  bad_cloud.width(1000);
  bad_cloud.height(1);
  const auto beat = node_.create_wall_timer(0.02, [&] {
    scan_.publish(bad_scan);
    cloud_.publish(bad_cloud);
  });
  ASSERT_TRUE(wait_until([&] {
    return log_.lines("scan refused: angle_min and angle_increment must be finite") > 0 &&
           log_.lines("cloud_in refused: no field `x`") > 0;
  }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
  EXPECT_FALSE(is_occupied(kRobotOnMap.x + 1.001, kRobotOnMap.y));
}

// A laser that looks back from a mast, with its pose given late by two messages on /tf_static.
TEST_F(BuilderOverDds, WhereASensorSitsIsWhatTfStaticSaysOfItsFrame) {
  auto ahead = scan(std::numeric_limits<float>::infinity());
  ahead.header().frame_id("laser");
  ahead.ranges()[0] = 2.001F;
  const auto beat = node_.create_wall_timer(0.05, [&] {
    ahead.header().stamp(node_.stamp());
    scan_.publish(ahead);
  });
  ASSERT_TRUE(wait_until([&] {
    return log_.lines(
               "scan dropped: /tf_static does not say where its frame `laser` is on "
               "`base_link`") > 0;
  }));
  EXPECT_EQ(maps_, 0);
  publish_frame("base_link", "mast", Eigen::Isometry3d{Eigen::Translation3d(-0.5, 0.0, 0.0)});
  publish_frame("mast", "laser",
                Eigen::Translation3d(0.0, 0.0, 0.3) *
                    Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  ASSERT_TRUE(wait_until([&] { return maps_ > 0; }));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x, kRobotOnMap.y - 2.501));
  EXPECT_FALSE(is_occupied(kRobotOnMap.x, kRobotOnMap.y + 2.001));
}

TEST_F(BuilderOverDds, AFrameThatIsNotFiniteIsRefused) {
  Eigen::Isometry3d nowhere = Eigen::Isometry3d::Identity();
  nowhere.translation().x() = kNaN;
  publish_frame("base_link", "base_scan", nowhere);
  ASSERT_TRUE(wait_until(
      [&] { return log_.lines("/tf_static of `base_scan` is not finite: dropped") > 0; }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
}

// Points all over the window, as from a faulty camera, may cost only a moment.
TEST_F(BuilderOverDds, ACloudOfNoiseIsSurvived) {
  ASSERT_TRUE(wait_for_maps(1));
  std::mt19937 random{1};
  std::uniform_real_distribution<float> wide(-5.0F, 5.0F), high(-0.6F, 1.0F);
  std::vector<Eigen::Vector3f> points;
  for (unsigned i = 0; i < kNoise; ++i)
    points.emplace_back(wide(random), wide(random), high(random));
  cloud_.publish(cloud_of(points, header(node_.stamp(), "base_scan")));
  ASSERT_TRUE(wait_until([&] {
    return is_occupied(kRobotOnMap.x + 1.0, kRobotOnMap.y + 1.0) ||
           tree_->getNumLeafNodes() > 50'000;
  }));
  EXPECT_TRUE(wait_for_maps(5));
}

TEST_F(BuilderOverDds, ResetForgetsAllThatWasSeen) {
  ASSERT_TRUE(wait_for_maps(1));
  ASSERT_TRUE(is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y));
  const auto client =
      node_.create_client(rt::ServiceName<std_srvs::srv::Trigger>{"/octomap_builder/reset"});
  bool answered = false;
  client.call({}, [&](const auto& response) { answered = response.success(); });
  ASSERT_TRUE(wait_until([&] { return answered; }));
  const auto beat = node_.create_wall_timer(0.05, [this] { scan_.publish(scan(2.0F)); });
  EXPECT_TRUE(wait_until([&] {
    return is_occupied(kRobotOnMap.x + 2.001, kRobotOnMap.y) &&
           !is_occupied(kRobotOnMap.x + 3.001, kRobotOnMap.y);
  }));
}

TEST_F(BuilderOverDds, AScanOfATimeWithoutOdometryIsDropped) {
  ASSERT_TRUE(wait_for_maps(1));
  auto old = scan(1.0F);
  old.header().stamp().sec(old.header().stamp().sec() - 100);
  const auto beat = node_.create_wall_timer(0.02, [&] { scan_.publish(old); });
  ASSERT_TRUE(wait_until([&] { return log_.lines("scan dropped: no odometry of its time") > 0; }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_FALSE(is_occupied(kRobotOnMap.x + 1.001, kRobotOnMap.y));
}

}  // namespace
}  // namespace tandem::test
