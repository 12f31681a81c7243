// SPDX-License-Identifier: Apache-2.0
// Tests the map of Nav2's map_server as the static map, over DDS.
#include <numbers>

#include "support/captured_log.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {
namespace {

constexpr double kAsked = 0.3;  // [m/s] asked for
constexpr int kCells = 80;      // of 0.1 m along each side, with the robot at the centre

// A free room as map_server publishes it, with one column of other cells ahead of the robot.
nav_msgs::msg::OccupancyGrid room(std::int8_t column, double yaw = 0.0) {
  nav_msgs::msg::OccupancyGrid msg;
  msg.header(header({}, "map"));
  msg.info().resolution(0.1F);
  msg.info().width(kCells);
  msg.info().height(kCells);
  const double half = 0.05 * kCells;
  const Eigen::Vector2d p_MO = transform({0.0, 0.0, yaw}, {-half, -half});
  msg.info().origin(to_msg(Pose2{p_MO.x(), p_MO.y(), yaw}));
  msg.data().assign(kCells * kCells, 0);
  msg.data()[0] = 100;  // something stands in every map
  for (std::size_t row = 0; row < kCells; ++row)
    msg.data()[row * kCells + kCells / 2 + 5] = column;  // from 0.5 m on
  return msg;
}

class FilterOnGrid : public OneComponent {
 protected:
  FilterOnGrid() {
    out_ = node_.create_subscription(topics::cmd_vel,
                                     [this](const auto& msg) { v_ = msg.linear().x(); });
    status_ = node_.create_subscription(
        topics::filter_status, [this](const auto& msg) { reason_ = from_msg(msg.reason_code()); });
    beat_ = node_.create_wall_timer(0.02, [this] {
      odom_.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
      command_.publish(to_msg(Twist2{kAsked, 0.0}));
    });
  }

  static rt::RunningComponent filter(Values more) {
    more.insert({{"map_is_odom", "true"}, {"static_map", "grid"}});
    return load("safety_filter", more);
  }
  [[nodiscard]] bool drives() {
    return wait_until([this] { return v_ == kAsked && reason_ == Reason::kClear; });
  }
  [[nodiscard]] bool is_slowed() {
    return wait_until([this] { return v_ >= 0.0 && v_ < kAsked && reason_ != Reason::kClear; });
  }

  CapturedLog log_;
  double v_ = -1.0;
  Reason reason_ = Reason::kNone;
  rt::Publisher<nav_msgs::msg::OccupancyGrid> map_ = node_.create_publisher(topics::map);
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Subscription out_, status_;
  rt::Timer beat_;
};

TEST_F(FilterOnGrid, StandsUntilTheMapArrivesAndRespectsItsWalls) {
  const auto running = filter({});
  ASSERT_TRUE(wait_until([this] { return v_ == 0.0 && reason_ == Reason::kNoMapYet; }));
  map_.publish(room(0));
  ASSERT_TRUE(drives());
  map_.publish(room(100));
  EXPECT_TRUE(is_slowed());
}

TEST_F(FilterOnGrid, ReceivesAMapPublishedEarlier) {
  map_.publish(room(0));
  const auto running = filter({});
  EXPECT_TRUE(drives());
}

TEST_F(FilterOnGrid, RespectsTheWallsOfARotatedMap) {
  const auto running = filter({});
  map_.publish(room(100, std::numbers::pi));  // the wall is behind
  ASSERT_TRUE(drives());
  map_.publish(room(100, 0.3));
  EXPECT_TRUE(is_slowed());
}

TEST_F(FilterOnGrid, TakesUnknownCellsForFreeUnlessToldOtherwise) {
  const auto running = filter({});
  map_.publish(room(-1));
  EXPECT_TRUE(drives());
}

TEST_F(FilterOnGrid, TakesUnknownCellsForObstaclesIfToldSo) {
  const auto running = filter({{"unknown_is_obstacle", "true"}});
  map_.publish(room(-1));
  EXPECT_TRUE(is_slowed());
}

TEST_F(FilterOnGrid, RefusesAMapThatContradictsItselfAndKeepsTheOneBefore) {
  const auto running = filter({});
  map_.publish(room(0));
  ASSERT_TRUE(drives());
  auto broken = room(100);
  broken.info().width(1'000'000'000);
  map_.publish(broken);
  ASSERT_TRUE(wait_until([this] { return log_.lines("map refused: 1000000000 × 80 cells") > 0; }));
  EXPECT_TRUE(drives());
}

// Grid and lidar together: obstacles of the map persist although the lidar sees over them;
// obstacles that the lidar sees appear and disappear.
TEST_F(FilterOnGrid, WithLiveSensingItRespectsBoth) {
  const auto running = filter({{"map_source", "both"}});
  const auto local = node_.create_publisher(topics::octomap_local);
  octomap::OcTree tree(0.05);
  for (int x = -20; x <= 40; ++x)
    for (int y = -20; y <= 20; ++y)
      tree.updateNode(octomap::point3d(0.05F * static_cast<float>(x) + 0.01F,
                                       0.05F * static_cast<float>(y) + 0.01F, 0.3F),
                      false);
  octomap_msgs::msg::Octomap seen;
  seen.header(header({}, "map"));
  seen.binary(true);
  seen.id("OcTree");
  seen.resolution(0.05);
  seen.data(encode_octomap(tree));
  const auto looks = node_.create_wall_timer(0.1, [&] { local.publish(seen); });

  map_.publish(room(0));
  ASSERT_TRUE(drives());
  map_.publish(room(100));
  ASSERT_TRUE(is_slowed());
  map_.publish(room(0));
  ASSERT_TRUE(drives());
  for (int y = -20; y <= 20; ++y)
    tree.setNodeValue(octomap::point3d(0.52F, 0.05F * static_cast<float>(y) + 0.01F, 0.3F), 3.0F);
  seen.data(encode_octomap(tree));
  EXPECT_TRUE(is_slowed());
}

}  // namespace
}  // namespace tandem::test
