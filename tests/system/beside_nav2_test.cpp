// SPDX-License-Identifier: Apache-2.0
// Drives the system of the tutorial "beside Nav2" with a publisher of cmd_vel_nav in Nav2's place.
#include <cmath>
#include <optional>
#include <string>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kLong = 60.0;   // [s] for a slow machine
constexpr double kWay = 0.5;     // [m]
constexpr double kSlow = 0.005;  // [m/s] counts as standing

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

  [[nodiscard]] bool has_moved() const {
    return start_ && (now_->X.position() - start_->X.position()).norm() > kWay;
  }
  [[nodiscard]] bool stands() const { return std::abs(now_->twist.v) < kSlow; }

  ChildProcess system_{"../tandem", {"run", source_path("tests/example_nav2/beside_nav2.yaml")}};
  std::optional<Odometry> start_, now_;
  std::optional<unsigned> collisions_;
  rt::Subscription truth_, collision_;
  rt::Publisher<geometry_msgs::msg::Twist> nav_ = node_.create_publisher(topics::cmd_vel_nav);
};

TEST_F(BesideNav2, TheFilterStopsAnAutonomyThatDrivesAtAWall) {
  const auto beat = node_.create_wall_timer(0.05, [this] {
    nav_.publish(to_msg(Twist2{0.5, 0.0}));
  });
  ASSERT_TRUE(spin_until([this] { return has_moved(); }, kLong, node_));
  ASSERT_TRUE(spin_until([this] { return stands(); }, kLong, node_));
  EXPECT_EQ(collisions_, 0U);
}

TEST_F(BesideNav2, TheRobotStandsOnceTheAutonomyIsSilent) {
  auto beat = node_.create_wall_timer(0.05, [this] { nav_.publish(to_msg(Twist2{0.5, 0.0})); });
  ASSERT_TRUE(spin_until([this] { return has_moved(); }, kLong, node_));
  const double x = now_->X.x;
  beat = {};
  ASSERT_TRUE(spin_until([this] { return stands(); }, kLong, node_));
  EXPECT_LT(now_->X.x - x, 1.0);  // [m]; the wall is farther away
}

}  // namespace
}  // namespace tandem::test
