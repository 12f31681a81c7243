// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <utility>
#include <vector>

#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kLeash = 0.4;      // [m]
constexpr double kScale = 0.8;      // of either axis, the default
const Pose2 kRobot{1.0, 2.0, 0.0};  // where odometry says it stands
const std::string kNotAtRest = "stick is not at rest";

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
  // Takes the stick as a person does: it is seen at rest with the dead-man held.
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
  std::optional<double> stamp_age_;       // [s]; none: without a stamp
  std::vector<float> axes_{-0.5f, 1.0f};  // right, ahead
  std::vector<int> buttons_{1, 0};        // dead-man, end
  Twist2 twist_;
  long commands_ = 0, zeros_ = 0, beats_ = 0;
  int ends_ = 0;
  std::string trouble_;  // why the stick moves nothing
  std::vector<Pose2> leads_;
  std::string leader_frame_;
  visualization_msgs::msg::MarkerArray drawn_;
};

TEST_F(TeleopOverDds, DrivesWhileTheDeadManIsHeldAndSaysOneZeroAtItsRelease) {
  take_stick();
  axes_ = {-1.0f, 1.0f};
  ASSERT_TRUE(wait_for(kScale, -kScale));
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_for(0.0, 0.0));
  const long until_release = commands_;
  buttons_ = {0, 1};  // the answer to it shows that released sticks were heard since
  ASSERT_TRUE(wait_until([&] { return ends_ > 0; }));
  EXPECT_EQ(commands_, until_release);
}

TEST_F(TeleopOverDds, AnAxisThatIsNotANumberIsAtRest) {
  take_stick();
  axes_ = {1.0f, 1.0f};
  ASSERT_TRUE(wait_for(kScale, kScale));
  axes_ = {1.0f, static_cast<float>(kNaN)};
  EXPECT_TRUE(wait_for(0.0, kScale));
  axes_ = {std::numeric_limits<float>::infinity(), 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

TEST_F(TeleopOverDds, AxesAndButtonsThatAJoystickLacksAreAtRest) {
  take_stick();
  axes_ = {1.0f, 1.0f};
  ASSERT_TRUE(wait_for(kScale, kScale));
  axes_ = {1.0f};
  EXPECT_TRUE(wait_for(0.0, kScale));
  EXPECT_TRUE(wait_until([&] { return trouble_ == "joy has no axis 1 (axis_linear)"; }));
  axes_ = {1.0f, 1.0f};
  ASSERT_TRUE(wait_for(kScale, kScale));
  EXPECT_TRUE(wait_until([&] { return trouble_.empty(); }));
  buttons_ = {};
  EXPECT_TRUE(wait_for(0.0, 0.0));
  EXPECT_TRUE(wait_until([&] { return trouble_ == "joy has no button 0 (deadman_button)"; }));
}

// A zero would tell that the stick was let go of. It may still be held when it is heard again.
TEST_F(TeleopOverDds, ASilentJoystickIsFollowedBySilenceUntilItIsSeenAtRest) {
  axes_ = {0.0f, 1.0f};
  take_stick();
  ASSERT_TRUE(wait_for(kScale, 0.0));
  const long zeros = zeros_;
  holds_joystick_ = false;
  ASSERT_TRUE(wait_beats(15));  // more than queues
  const long commands = commands_;
  ASSERT_TRUE(wait_beats(30));  // 0.6 s, twice joy_timeout
  EXPECT_EQ(commands_, commands);
  holds_joystick_ = true;
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(15));
  EXPECT_EQ(commands_, commands);
  EXPECT_EQ(zeros_, zeros);
  axes_ = {0.0f, 0.0f};
  ASSERT_TRUE(wait_for(0.0, 0.0));
  axes_ = {0.0f, 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
  EXPECT_TRUE(wait_until([&] { return trouble_.empty(); }));
}

// A pad that has not reported its axes yet, or a stick that lies on the table.
TEST_F(TeleopOverDds, AStickThatWasNeverSeenAtRestMovesNothingAndSaysSo) {
  axes_ = {0.0f, 0.99f};
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_beats(30));
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  axes_ = {0.0f, 0.0f};
  ASSERT_TRUE(wait_until([&] { return trouble_.empty() && commands_ > 0; }));
  axes_ = {0.0f, 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

TEST_F(TeleopOverDds, AStickThatIsPushedBeforeTheDeadManMovesNothing) {
  buttons_ = {0, 0};
  axes_ = {0.0f, 0.0f};
  ASSERT_TRUE(wait_beats(30));
  axes_ = {0.0f, 1.0f};
  ASSERT_TRUE(wait_beats(5));
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  EXPECT_EQ(commands_, 0);
}

// Two pads whose drivers give them one name.
TEST_F(TeleopOverDds, OneStickAtRestFreesNoOtherOfTheSameName) {
  const auto other = node_.create_publisher(topics::joy);
  ASSERT_TRUE(wait_until([&] { return other.matched() > 0; }));
  axes_ = {0.0f, 0.0f};
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_beats(30));
  const auto lies = node_.create_wall_timer(0.02, [&] {
    other.publish(joy({0.0f, 0.99f}, {1, 0}));
  });
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
  axes_ = {0.0f, 0.5f};
  EXPECT_TRUE(wait_until([&] { return twist_.v > 0.3; }));
}

// Bytes of −100 … 100, say: nobody knows how fast 5 is.
TEST_F(TeleopOverDds, AnAxisBeyondItsRangeIsReportedAndNotDrivenWith) {
  axes_ = {0.0f, 1.05f};
  take_stick();
  ASSERT_TRUE(wait_for(kScale, 0.0));
  axes_ = {0.0f, 5.0f};
  ASSERT_TRUE(wait_until([&] { return trouble_ == "axis 1 of joy is beyond axis_range"; }));
  ASSERT_TRUE(wait_beats(15));
  const long commands = commands_;
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, commands);
  buttons_ = {0, 0};
  EXPECT_TRUE(wait_for(0.0, 0.0)) << "letting go counts all the same";
}

class TeleopOfOtherRange : public TeleopOverDds {
 protected:
  TeleopOfOtherRange()
      : TeleopOverDds{{{"map_is_odom", "true"}, {"axis_range", "100.0"}, {"deadzone", "0.0"}}} {}
};

TEST_F(TeleopOfOtherRange, DrivesAsFarAsTheStickIsPushed) {
  axes_ = {0.0f, 5.0f};
  take_stick();
  EXPECT_TRUE(wait_for(0.05 * kScale, 0.0));
  axes_ = {0.0f, -100.0f};
  EXPECT_TRUE(wait_for(-kScale, 0.0));
}

class TeleopWithoutDeadMan : public TeleopOverDds {
 protected:
  TeleopWithoutDeadMan() : TeleopOverDds{{{"map_is_odom", "true"}, {"deadman_button", "-1"}}} {}
};

TEST_F(TeleopWithoutDeadMan, DrivesOnceItsStickWasSeenAtRest) {
  axes_ = {0.0f, 0.99f};
  buttons_ = {};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  axes_ = {0.0f, 1.0f};
  take_stick();
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

class TeleopOfALooseStick : public TeleopOverDds {
 protected:
  explicit TeleopOfALooseStick(const char* deadzone = "0.05")
      : TeleopOverDds{{{"map_is_odom", "true"}, {"deadzone", deadzone}}} {
    axes_ = {0.0f, 0.08f};  // where it rests
  }
};

TEST_F(TeleopOfALooseStick, MovesNothingWhileItsRestLiesOutsideTheDeadZone) {
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  axes_ = {0.0f, 1.0f};
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
}

class TeleopOfAWiderRest : public TeleopOfALooseStick {
 protected:
  TeleopOfAWiderRest() : TeleopOfALooseStick{"0.1"} {}
};

TEST_F(TeleopOfAWiderRest, DrivesIfTheDeadZoneAllowsForIt) {
  ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
  EXPECT_EQ(twist_, Twist2{});
  axes_ = {0.0f, 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

// --- somebody else's cmd_vel_user ----------------------------------------------------------------

class TeleopBesideAProgram : public TeleopOverDds {
 protected:
  TeleopBesideAProgram() {
    axes_ = {0.0f, 0.0f};
    buttons_ = {0, 0};
    program_beat_ = node_.create_wall_timer(0.05, [this] {
      program_.publish(to_msg(Twist2{program_v_, 0.0}));
    });
  }
  [[nodiscard]] bool leads_to(double x) {
    return wait_until([&] { return !leads_.empty() && std::abs(leads_.back().x - x) < 1e-6; });
  }

  rt::Publisher<geometry_msgs::msg::Twist> program_ = node_.create_publisher(topics::cmd_vel_user);
  double program_v_ = 0.5;
  rt::Timer program_beat_;
};

TEST_F(TeleopBesideAProgram, TheLeaderFollowsIt) {
  ASSERT_TRUE(leads_to(kRobot.x + kLeash));
  program_v_ = -0.5;
  EXPECT_TRUE(leads_to(kRobot.x - kLeash));
  program_beat_ = {};
  ASSERT_TRUE(wait_beats(30));
  const std::size_t leads = leads_.size();
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(leads_.size(), leads) << "silence is its dead-man";
}

TEST_F(TeleopBesideAProgram, OfTwoTheFirstLeadsUntilItIsSilent) {
  ASSERT_TRUE(leads_to(kRobot.x + kLeash));
  const auto second = node_.create_publisher(topics::cmd_vel_user);
  const auto beat = node_.create_wall_timer(0.03, [&] {
    second.publish(to_msg(Twist2{-0.5, 0.0}));
  });
  ASSERT_TRUE(wait_until([&] { return second.matched() >= program_.matched(); }));
  ASSERT_TRUE(wait_beats(50));
  EXPECT_NEAR(leads_.back().x, kRobot.x + kLeash, 1e-6);
  program_beat_ = {};
  EXPECT_TRUE(leads_to(kRobot.x - kLeash));
}

TEST_F(TeleopBesideAProgram, AHeldStickLeads) {
  ASSERT_TRUE(leads_to(kRobot.x + kLeash));
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_beats(15));
  axes_ = {0.0f, -1.0f};
  ASSERT_TRUE(leads_to(kRobot.x - kLeash));
  buttons_ = {0, 0};
  EXPECT_TRUE(leads_to(kRobot.x + kLeash));
}

TEST_F(TeleopBesideAProgram, TheLeaderFollowsOneThatStampsToo) {
  program_beat_ = {};
  const rt::Topic<geometry_msgs::msg::TwistStamped> topic{topics::cmd_vel_user.name};
  const auto stamped = node_.create_publisher(topic);
  const auto beat = node_.create_wall_timer(0.05, [&] {
    geometry_msgs::msg::TwistStamped msg;
    msg.header().stamp(ago(0.0));
    msg.twist(to_msg(Twist2{0.5, 0.0}));
    stamped.publish(msg);
  });
  EXPECT_TRUE(leads_to(kRobot.x + kLeash));
}

TEST_F(TeleopOverDds, WhatIsLateByItsStampIsNoStick) {
  take_stick();
  axes_ = {0.0f, 1.0f};
  stamp_age_ = 0.0;
  ASSERT_TRUE(wait_for(kScale, 0.0));
  for (const double age : {0.7, -0.7}) {
    const double before = twist_.v;
    axes_[1] = -axes_[1];
    stamp_age_ = age;
    ASSERT_TRUE(wait_beats(15));  // more than queues
    const long commands = commands_;
    ASSERT_TRUE(wait_beats(30));
    EXPECT_EQ(commands_, commands) << age;
    EXPECT_EQ(twist_.v, before) << age;
    stamp_age_ = 0.0;
    EXPECT_TRUE(wait_for(-before, 0.0)) << age;
  }
}

TEST_F(TeleopOverDds, TheEndButtonEndsOncePerPress) {
  take_stick();
  ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
  for (const int press : {1, 2}) {
    buttons_ = {1, 1};
    ASSERT_TRUE(wait_until([&] { return ends_ == press; }));
    const long held_since = commands_;
    ASSERT_TRUE(wait_until([&] { return commands_ > held_since + 5; }));
    EXPECT_EQ(ends_, press);
    buttons_ = {1, 0};
    const long released_since = commands_;
    ASSERT_TRUE(wait_until([&] { return commands_ > released_since + 15; }));  // more than queues
  }
}

TEST_F(TeleopOverDds, TheLeaderRunsAheadToTheEndOfItsLeashAndIsDrawn) {
  take_stick();
  axes_ = {0.0f, 1.0f};
  ASSERT_TRUE(
      wait_until([&] { return !leads_.empty() && leads_.back().x > kRobot.x + kLeash - 1e-6; }));
  for (const Pose2& X_ML : leads_) {
    EXPECT_LE((X_ML.position() - kRobot.position()).norm(), kLeash + 1e-9);
    EXPECT_NEAR(X_ML.y, kRobot.y, 1e-9);
  }
  EXPECT_EQ(leader_frame_, "map");
  ASSERT_TRUE(wait_until([&] {
    return drawn_.markers().size() == 2 &&
           drawn_.markers()[0].pose().position().x() > kRobot.x + kLeash - 1e-6;
  }));
  const auto& leash = drawn_.markers()[1];
  EXPECT_EQ(leash.header().frame_id(), "map");
  ASSERT_EQ(leash.points().size(), 2u);
  EXPECT_NEAR(leash.points()[0].x(), kRobot.x, 1e-9);
  EXPECT_NEAR(leash.points()[1].x(), kRobot.x + kLeash, 1e-6);
}

class TeleopWithLocaliser : public TeleopOverDds {
 protected:
  TeleopWithLocaliser() : TeleopOverDds{{{"map_is_odom", "false"}}} {}
};

TEST_F(TeleopWithLocaliser, HasNoLeaderUntilTheRobotIsLocalised) {
  take_stick();
  ASSERT_TRUE(wait_until([&] { return commands_ > 10; }));
  EXPECT_TRUE(leads_.empty());
  const auto tf = node_.create_publisher(topics::tf);
  tf2_msgs::msg::TFMessage msg;
  msg.transforms().push_back(to_transform({-5.0, 0.0, 0.0}, header({}, "map"), "odom"));
  const auto localiser = node_.create_wall_timer(0.02, [&] { tf.publish(msg); });
  ASSERT_TRUE(wait_until([&] { return !leads_.empty(); }));
  EXPECT_NEAR(leads_.front().x, kRobot.x - 5.0, kLeash);
}

}  // namespace
}  // namespace tandem::test
