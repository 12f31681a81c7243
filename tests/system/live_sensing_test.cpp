// SPDX-License-Identifier: Apache-2.0
// Drives robots that know obstacles only from their sensors, with one process per component.
#include "support/paths.hpp"
#include "support/point_cloud.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

// A cloud in base_link, at the scanner's height, of a pole at a position in the map. Without a pole
// the cloud is empty, as from a camera that sees nothing.
sensor_msgs::msg::PointCloud2 pole_at(const std::optional<Eigen::Vector2d>& p_MP, const Pose2& X_MB,
                                      double t) {
  constexpr int kPoints = 24;
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; p_MP && i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    const Eigen::Vector2d p_BQ =
        transform(inverse(X_MB), *p_MP + 0.15 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    points.emplace_back(static_cast<float>(p_BQ.x()), static_cast<float>(p_BQ.y()), 0.3F);
  }
  return cloud_of(points, header(rt::to_stamp(std::llround(t * 1e9)), "base_link"));
}

class LiveSensingInTheYard : public ::testing::Test {
 protected:
  LiveSensingInTheYard() {
    for (const char* name : {"octomap_builder", "arbitration", "safety_filter", "diff_drive_sim"})
      system_.start(name);
    push_ = node_.create_wall_timer(0.03, [this] {
      user_.publish(to_msg(Twist2{0.5, 0.0}));
      cloud_.publish(pole_at(pole_, system_.truth.X, system_.sim_time));
    });
  }
  [[nodiscard]] bool wait_until(const std::function<bool()>& done) {
    const auto heard_and_done = [&] { return system_.sim_time > 0.0 && done(); };
    return spin_until([&] { return system_.wait_until(heard_and_done, 0.005); }, 60.0, node_);
  }
  [[nodiscard]] double x() const { return system_.truth.X.x; }

  SystemUnderTest system_{source_path("tests/system/live_sensing_yard.yaml")};
  rt::Node node_{"person"};
  rt::Publisher<geometry_msgs::msg::Twist> user_ = node_.create_publisher(topics::cmd_vel_user);
  rt::Publisher<sensor_msgs::msg::PointCloud2> cloud_ = node_.create_publisher(topics::cloud_in);
  std::optional<Eigen::Vector2d> pole_;
  rt::Timer push_;
};

TEST_F(LiveSensingInTheYard, APoleThatOnlyACloudShowsStopsTheRobotUntilItIsGone) {
  ASSERT_TRUE(wait_until([&] { return x() > -3.0; }));  // drives, without any map
  pole_ = {-1.0, 0.0};
  ASSERT_TRUE(wait_until([&] { return x() > -2.5 && system_.stands(); }));
  EXPECT_LT(x() + 0.038 + 0.445, -1.15);  // the bumper is this side of the pole
  EXPECT_GT(x(), -2.1);                   // and has come near it
  pole_.reset();
  ASSERT_TRUE(wait_until([&] { return x() > -0.5; }));
  ASSERT_TRUE(wait_until([&] { return x() > 3.5 && system_.stands(); }));  // the wall, by the scan
  EXPECT_EQ(system_.collisions, 0U);
}

TEST_F(LiveSensingInTheYard, ARobotWhoseSensorsFallSilentStops) {
  ASSERT_TRUE(wait_until([&] { return x() > -3.0 && system_.truth.twist.v > 0.3; }));
  system_.kill_hard("octomap_builder");
  EXPECT_TRUE(wait_until([&] { return system_.stands() && system_.command == Twist2{}; }));
  EXPECT_LT(x(), 2.0);
}

TEST(LiveSensing, PolesThatTheMapLacksAreDrivenRound) {
  SystemUnderTest system{source_path("tests/system/live_sensing_forest.yaml")};
  system.start_all();
  system.start("octomap_builder");
  rt::Node node{"planner_beside"};
  const Eigen::Vector2d pole{-1.0, -4.0};  // of the forest, half a metre from the way
  bool is_listed = false;
  const auto list = node.create_subscription(topics::obstacles, [&](const auto& msg) {
    for (const Obstacle& obstacle : from_msg(msg).all)
      is_listed = is_listed || (obstacle.p_MO - pole).norm() < 0.3;
  });
  ASSERT_TRUE(system.wait_until_driving());
  ASSERT_TRUE(
      spin_until([&] { return system.wait_until([&] { return is_listed; }, 0.005); }, 30.0, node));
  ASSERT_TRUE(system.wait_until([&] { return system.truth.X.x > 1.5; }, 180.0));
  EXPECT_EQ(system.collisions, 0U);
}

}  // namespace
}  // namespace tandem::test
