// SPDX-License-Identifier: Apache-2.0
// Runs teleop over real DDS with a joystick whose data the test sets.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "system/one_component.hpp"

namespace tandem::test {

inline constexpr double kLeash = 0.4;      // [m]
inline constexpr double kScale = 0.8;      // of both axes, the default
inline const Pose2 kRobot{1.0, 2.0, 0.0};  // the robot's pose in odometry
inline const std::string kNotAtRest = "stick is not at rest";

class TeleopOverDds : public OneComponent {
 protected:
  explicit TeleopOverDds(const Values& values = {{"map_is_odom", "true"}}) {
    Values all{{"leash", std::to_string(kLeash)}, {"joy_timeout", "0.3"}};
    all.insert(values.begin(), values.end());
    teleop_ = std::make_unique<rt::RunningComponent>(load("teleop", all));
    user_ = node_.create_subscription(topics::cmd_vel_user, [this](const auto& msg) {
      twist_ = {msg.linear().x(), msg.angular().z()};
      zeros_ += twist_ == Twist2{} ? 1 : 0;
      ++commands_;
    });
    leader_ = node_.create_subscription(topics::leader_pose, [this](const auto& msg) {
      leads_.push_back(from_msg(msg.pose()).value());
      leader_frame_ = msg.header().frame_id();
    });
    markers_ = node_.create_subscription(topics::leader_markers,
                                         [this](const auto& msg) { drawn_ = msg; });
    status_ = node_.create_subscription(topics::teleop_status,
                                        [this](const auto& msg) { trouble_ = msg.data(); });
    end_ = node_.create_subscription(topics::end_sim,
                                     [this](const auto& msg) { ends_ += msg.data() ? 1 : 0; });
    beat_ = node_.create_wall_timer(0.02, [this] { beat(); });
  }

  void beat() {
    odom_.publish(to_msg(Odometry{kRobot, {}}, header({}, "odom"), "base_link"));
    if (holds_joystick_) joy_.publish(joy(axes_, buttons_));
    ++beats_;
  }
  [[nodiscard]] sensor_msgs::msg::Joy joy(const std::vector<float>& axes,
                                          const std::vector<int>& buttons) const {
    sensor_msgs::msg::Joy msg;
    if (stamp_age_) msg.header().stamp(ago(*stamp_age_));
    msg.axes(axes);
    msg.buttons(buttons);
    return msg;
  }
  // Takes control as a person does: the stick is first seen at rest with the dead-man button held.
  void take_stick() {
    const auto pushed = std::exchange(axes_, {0.0f, 0.0f});
    ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
    axes_ = pushed;
  }
  [[nodiscard]] bool wait_beats(long count) {
    return wait_until([&, end = beats_ + count] { return beats_ >= end; });
  }
  [[nodiscard]] bool wait_for(double v, double w) {
    return wait_until([&] { return is_near(twist_.v, v) && is_near(twist_.w, w); });
  }

  std::unique_ptr<rt::RunningComponent> teleop_;
  rt::Publisher<sensor_msgs::msg::Joy> joy_ = node_.create_publisher(topics::joy);
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Subscription user_, leader_, markers_, end_, status_;
  rt::Timer beat_;

  bool holds_joystick_ = true;
  std::optional<double> stamp_age_;       // [s]; empty: no timestamp
  std::vector<float> axes_{-0.5f, 1.0f};  // right, forward
  std::vector<int> buttons_{1, 0};        // dead-man, end
  Twist2 twist_;
  long commands_ = 0, zeros_ = 0, beats_ = 0;
  int ends_ = 0;
  std::string trouble_;  // why the stick has no effect
  std::vector<Pose2> leads_;
  std::string leader_frame_;
  visualization_msgs::msg::MarkerArray drawn_;
};

}  // namespace tandem::test
