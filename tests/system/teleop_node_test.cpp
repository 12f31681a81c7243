// SPDX-License-Identifier: Apache-2.0
#include "system/teleop_over_dds.hpp"

namespace tandem::test {
namespace {

TEST_F(TeleopOverDds, DrivesWhileTheDeadManIsHeldAndPublishesOneZeroAtItsRelease) {
  take_stick();
  axes_ = {-1.0f, 1.0f};
  ASSERT_TRUE(wait_for(kScale, -kScale));
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_for(0.0, 0.0));
  const long until_release = commands_;
  buttons_ = {0, 1};  // the answer to it shows that released sticks have arrived since
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

// A zero would mean that the stick was released, but it may still be held when messages resume.
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

TEST_F(TeleopOverDds, AJoyMessageWithALateStampIsDropped) {
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
