// SPDX-License-Identifier: Apache-2.0
// Drives the system of the tutorial "beside Nav2" with a publisher of cmd_vel_nav in Nav2's place.
#include <cmath>
#include <optional>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kNavigated = 0.5;  // [m]
constexpr double kSlow = 0.005;     // [m/s] counts as standing
constexpr double kNearWall = 3.8;  // [m] in x; the wall is at 5, the robot's front 0.48 ahead of it

class BesideNav2 : public OneComponent {
 protected:
  BesideNav2() {
    truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      now_ = from_msg(msg);
      if (!start_) start_ = now_;
    });
    collision_ = node_.create_subscription(topics::collision,
                                           [this](const auto& msg) { collisions_ = msg.count(); });
  }

  // Publishes 0.5 m/s ahead at 20 Hz while the timer exists.
  [[nodiscard]] rt::Timer drive_ahead() {
    return node_.create_wall_timer(0.05, [this] { nav_.publish(to_msg(Twist2{0.5, 0.0})); });
  }
  [[nodiscard]] bool has_moved() const {
    return start_ && (now_->X.position() - start_->X.position()).norm() > kNavigated;
  }
  [[nodiscard]] bool stands() const { return std::abs(now_->twist.v) < kSlow; }

  ChildProcess system_{"../tandem", {"run", source_path("tests/example_nav2/beside_nav2.yaml")}};
  std::optional<Odometry> start_, now_;
  std::optional<unsigned> collisions_;
  rt::Subscription truth_, collision_;
  rt::Publisher<geometry_msgs::msg::Twist> nav_ = node_.create_publisher(topics::cmd_vel_nav);
};

TEST_F(BesideNav2, TheFilterStopsAnAutonomyThatDrivesAtAWall) {
  const rt::Timer nav2 = drive_ahead();
  ASSERT_TRUE(spin_until([this] { return has_moved(); }, kLongTimeout, node_));
  ASSERT_TRUE(
      spin_until([this] { return now_->X.x > kNearWall && stands(); }, kLongTimeout, node_));
  EXPECT_EQ(collisions_, 0U);
}

TEST_F(BesideNav2, TheRobotStandsOnceTheAutonomyIsSilent) {
  rt::Timer nav2 = drive_ahead();
  ASSERT_TRUE(spin_until([this] { return has_moved(); }, kLongTimeout, node_));
  const double x = now_->X.x;
  nav2 = {};
  ASSERT_TRUE(spin_until([this] { return stands(); }, kLongTimeout, node_));
  EXPECT_LT(now_->X.x - x, 1.0);  // [m]; the wall is farther away
}

}  // namespace
}  // namespace tandem::test
