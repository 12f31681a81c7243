// SPDX-License-Identifier: Apache-2.0
// Nav2's actions of the planner, and what nav2_facade answers.
#include "system/planner_over_dds.hpp"
#include "tandem/runtime/action_client.hpp"

namespace tandem::test {
namespace {

using nav2_msgs::action::FollowPath;
using nav2_msgs::action::NavigateToPose;
using rt::GoalReply;
using rt::GoalStatus;

// A client of one action, which keeps what it is told about its last goal.
template <class A>
struct Asker {
  explicit Asker(rt::Node& node, const rt::ActionName<A>& action)
      : client{node.create_action_client(action)} {}

  void send(const typename A::Goal& goal) {
    reply.reset();
    ended.reset();
    result = {};
    feedbacks = 0;
    id = client.send(goal,
                     {.on_reply = [this](GoalReply told) { reply = told; },
                      .on_feedback =
                          [this](const auto& told) {
                            feedback = told;
                            ++feedbacks;
                          },
                      .on_result =
                          [this](GoalStatus status, const auto& told) {
                            ended = status;
                            result = told;
                          }},
                     kTimeout);
  }

  rt::ActionClient<A> client;
  rt::GoalId id{};
  std::optional<GoalReply> reply;
  std::optional<GoalStatus> ended;
  typename A::Feedback feedback;
  typename A::Result result;
  int feedbacks = 0;
};

// The planner, with arbitration and safety filter as the test wants them to report.
class Navigation : public PlannerOverDds {
 protected:
  explicit Navigation(Values values = {}) : PlannerOverDds{with_actions(std::move(values))} {
    report_ = node_.create_wall_timer(kBeat, [this] { report(); });
  }
  static Values with_actions(Values values) {
    values.emplace("method", "goal");
    values.emplace("serve_actions", "true");
    return values;
  }

  void report() {
    tandem_msgs::msg::ArbitrationStatus arbitration;
    arbitration.policy(policy_);
    arbitration.emergency_stop(stopped_);
    arbitration_.publish(arbitration);
    tandem_msgs::msg::FilterStatus filter;
    filter.enforcing(enforces_);
    if (filter_lives_) filter_.publish(filter);
  }
  static NavigateToPose::Goal pose(const Pose2& X, const std::string& frame = "map") {
    NavigateToPose::Goal goal;
    goal.pose(to_msg(X, header({}, frame)));
    return goal;
  }
  // The planner must have heard of arbitration and filter, or it rejects the goal.
  template <class A>
  void accept(Asker<A>& asker, const typename A::Goal& goal) {
    ASSERT_TRUE(wait_until([&] {
      if (asker.reply == GoalReply::kRejected || asker.id == rt::GoalId{}) asker.send(goal);
      return asker.reply == GoalReply::kAccepted;
    }));
  }
  void drive_far() {
    accept(to_pose_, pose({50.0, 0.0, 0.0}));
    ASSERT_TRUE(wait_until([&] { return command_.v > 0.2 && to_pose_.feedbacks > 0; }));
  }
  // The goal ended like that, and the robot stands although nothing prevents driving any more.
  void expect_aborted(int code, const std::string& why) {
    ASSERT_TRUE(wait_until([&] { return to_pose_.ended.has_value(); }));
    EXPECT_EQ(to_pose_.ended, GoalStatus::kAborted);
    EXPECT_EQ(to_pose_.result.error_code(), code);
    EXPECT_NE(to_pose_.result.error_msg().find(why), std::string::npos)
        << to_pose_.result.error_msg();
    policy_ = "autonomous";
    stopped_ = sees_nan_ = false;
    enforces_ = filter_lives_ = true;
    EXPECT_TRUE(wait_until_standing(Reason::kNoGoal));
  }

  rt::Publisher<tandem_msgs::msg::ArbitrationStatus> arbitration_ =
      node_.create_publisher(topics::arbitration_status);
  rt::Publisher<tandem_msgs::msg::FilterStatus> filter_ =
      node_.create_publisher(topics::filter_status);
  Asker<NavigateToPose> to_pose_{node_, actions::navigate_to_pose};
  std::string policy_ = "autonomous";
  bool stopped_ = false, enforces_ = true, filter_lives_ = true;
  rt::Timer report_;
};

TEST_F(Navigation, DrivesToAPoseAndTellsHowItGoesOn) {
  accept(to_pose_, pose({1.0, 0.0, 0.0}));
  ASSERT_TRUE(wait_until([&] { return to_pose_.feedbacks > 0; }));
  EXPECT_GT(to_pose_.feedback.distance_remaining(), 0.1);
  EXPECT_EQ(to_pose_.feedback.current_pose().header().frame_id(), "map");
  EXPECT_EQ(to_pose_.feedback.number_of_recoveries(), 0);
  ASSERT_TRUE(wait_until([&] { return to_pose_.ended.has_value(); }));
  EXPECT_EQ(to_pose_.ended, GoalStatus::kSucceeded);
  EXPECT_EQ(to_pose_.result.error_code(), 0);
  EXPECT_NEAR(X_.x, 1.0, 0.15);
  EXPECT_TRUE(wait_until_standing(Reason::kNoGoal));
}

TEST_F(Navigation, RejectsAGoalInAnotherPolicyAndLogsWhy) {
  policy_ = "shared";
  ASSERT_TRUE(wait_until([&] {
    if (to_pose_.reply || to_pose_.id == rt::GoalId{}) to_pose_.send(pose({1.0, 0.0, 0.0}));
    return log_.lines("goal rejected: the policy is shared, not autonomous") > 0;
  }));
  EXPECT_NE(to_pose_.reply, GoalReply::kAccepted);
  EXPECT_EQ(X_, Pose2{});
}

TEST_F(Navigation, RejectsAPathInMethodGoal) {
  Asker<FollowPath> along{node_, actions::follow_path};
  accept(to_pose_, pose({50.0, 0.0, 0.0}));  // from now on it knows the others
  along.send({});
  ASSERT_TRUE(wait_until([&] { return along.reply.has_value(); }));
  EXPECT_EQ(along.reply, GoalReply::kRejected);
  EXPECT_EQ(log_.lines("goal rejected: the planner's method is goal, not path"), 1);
}

TEST_F(Navigation, RejectsAPoseThatIsNotANumberOrInAnUnknownFrame) {
  accept(to_pose_, pose({50.0, 0.0, 0.0}));
  for (const auto& goal : {pose({kNaN, 0.0, 0.0}), pose({1.0, 0.0, 0.0}, "nowhere")}) {
    Asker<NavigateToPose> other{node_, actions::navigate_to_pose};
    other.send(goal);
    ASSERT_TRUE(wait_until([&] { return other.reply.has_value(); }));
    EXPECT_EQ(other.reply, GoalReply::kRejected);
  }
  EXPECT_FALSE(to_pose_.ended);
}

TEST_F(Navigation, BrakesWhenItsGoalIsCancelled) {
  drive_far();
  to_pose_.client.cancel(to_pose_.id);
  ASSERT_TRUE(wait_until([&] { return to_pose_.ended.has_value(); }));
  EXPECT_EQ(to_pose_.ended, GoalStatus::kCanceled);
  EXPECT_TRUE(wait_until_standing(Reason::kNoGoal));
}

TEST_F(Navigation, ReplacesAGoalByANewOne) {
  drive_far();
  Asker<NavigateToPose> other{node_, actions::navigate_to_pose};
  accept(other, pose({X_.x + 1.0, 0.0, 0.0}));
  ASSERT_TRUE(wait_until([&] { return to_pose_.ended && other.ended; }));
  EXPECT_EQ(to_pose_.ended, GoalStatus::kAborted);
  EXPECT_EQ(to_pose_.result.error_msg(), "replaced by a new goal");
  EXPECT_EQ(other.ended, GoalStatus::kSucceeded);
}

TEST_F(Navigation, FollowsGoalPoseInstead) {
  drive_far();
  send_goal({-50.0, 0.0, 0.0});
  ASSERT_TRUE(wait_until([&] { return to_pose_.ended.has_value(); }));
  EXPECT_EQ(to_pose_.result.error_msg(), "replaced by goal_pose");
  EXPECT_TRUE(wait_until([&] { return X_.x < 0.0 || command_.v < 0.0; }));
}

TEST_F(Navigation, EndsWithTheEmergencyStop) {
  drive_far();
  stopped_ = true;
  expect_aborted(9000, "emergency stop");
}

TEST_F(Navigation, EndsWithThePolicy) {
  drive_far();
  policy_ = "shared";
  expect_aborted(9000, "the policy is shared");
}

TEST_F(Navigation, EndsWhenTheRobotIsNotLocalised) {
  drive_far();
  sees_nan_ = true;
  expect_aborted(9002, "not localized");
}

TEST_F(Navigation, EndsWhenTheFilterDies) {
  drive_far();
  filter_lives_ = false;
  expect_aborted(9000, "the safety filter is silent");
}

TEST_F(Navigation, EndsWhenTheFilterNoLongerEnforces) {
  drive_far();
  enforces_ = false;
  expect_aborted(9000, "does not enforce");
}

TEST_F(Navigation, GoesOnWhileThePersonSteers) {
  drive_far();
  user_ = {0.0, 0.5};
  const int before = to_pose_.feedbacks;
  EXPECT_TRUE(wait_until([&] { return to_pose_.feedbacks > before + 5; }));
  EXPECT_FALSE(to_pose_.ended);
}

TEST_F(Navigation, GoesOnWithoutItsClient) {
  drive_far();
  to_pose_.client = {};
  const double before = X_.x;
  EXPECT_TRUE(wait_until([&] { return X_.x > before + 0.5 && command_.v > 0.2; }));
}

class NavigationWithClient : public Navigation {
 protected:
  NavigationWithClient() : Navigation{{{"goal_needs_client", "true"}}} {}
};

TEST_F(NavigationWithClient, BrakesWithoutItsClient) {
  drive_far();
  to_pose_.client = {};
  EXPECT_TRUE(wait_until_standing(Reason::kNoGoal));
  EXPECT_EQ(log_.lines("its client has left"), 1);
}

class PathNavigation : public Navigation {
 protected:
  PathNavigation() : Navigation{{{"method", "path"}}} {}
  static FollowPath::Goal path(const std::vector<Pose2>& poses) {
    FollowPath::Goal goal;
    goal.path(to_path(poses, header({}, "map")));
    return goal;
  }
  Asker<FollowPath> along_{node_, actions::follow_path};
};

TEST_F(PathNavigation, FollowsAPathToItsEnd) {
  accept(along_, path({{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 2.0, 0.5 * std::numbers::pi}}));
  double farthest = 0.0;  // [m] from the path
  ASSERT_TRUE(wait_until([&] {
    farthest = std::max(farthest, std::min(std::abs(X_.y), std::abs(X_.x - 2.0)));
    return along_.ended.has_value();
  }));
  EXPECT_EQ(along_.ended, GoalStatus::kSucceeded);
  EXPECT_NEAR(X_.x, 2.0, 0.15);
  EXPECT_NEAR(X_.y, 2.0, 0.15);
  EXPECT_LT(farthest, 0.35);
  EXPECT_GT(along_.feedbacks, 5);
  EXPECT_TRUE(wait_until_standing(Reason::kLeaderSilent));
}

TEST_F(PathNavigation, TellsTheWayThatIsLeft) {
  accept(along_, path({{0.0, 0.0, 0.0}, {20.0, 0.0, 0.0}}));
  ASSERT_TRUE(wait_until([&] { return X_.x > 1.0 && along_.feedbacks > 0; }));
  EXPECT_LT(along_.feedback.distance_to_goal(), 19.5);
  EXPECT_GT(along_.feedback.distance_to_goal(), 17.0);
  EXPECT_GT(along_.feedback.speed(), 0.1);
}

TEST_F(PathNavigation, RejectsAnEmptyPath) {
  accept(along_, path({{0.0, 0.0, 0.0}, {20.0, 0.0, 0.0}}));
  Asker<FollowPath> other{node_, actions::follow_path};
  other.send(path({}));
  ASSERT_TRUE(wait_until([&] { return other.reply.has_value(); }));
  EXPECT_EQ(other.reply, GoalReply::kRejected);
  EXPECT_EQ(log_.lines("goal rejected: the path is empty"), 1);
}

// What nav2_facade answers beside the planner.
class Facade : public Navigation {
 protected:
  std::string state_of(const rt::Client<lifecycle_msgs::srv::GetState>& client) {
    std::string label;
    client.call(
        {}, [&](const auto& response) { label = response.current_state().label(); }, kTimeout);
    EXPECT_TRUE(wait_until([&] { return !label.empty(); }));
    return label;
  }

  rt::RunningComponent facade_ =
      load("nav2_facade", {{"map_is_odom", "true"}, {"odom_timeout", "0.4"}});
  rt::Client<lifecycle_msgs::srv::GetState> localiser_ = node_.create_client(services::amcl_state),
                                            navigator_ =
                                                node_.create_client(services::navigator_state);
  rt::Client<std_srvs::srv::Trigger> is_active_ =
      node_.create_client(services::navigation_is_active);
};

TEST_F(Facade, IsActiveWhileAGoalWouldBeAccepted) {
  EXPECT_TRUE(wait_until([&] { return state_of(navigator_) == "active"; }));
  EXPECT_EQ(state_of(localiser_), "active");
  policy_ = "shared";
  EXPECT_TRUE(wait_until([&] { return state_of(navigator_) == "inactive"; }));
  EXPECT_EQ(state_of(localiser_), "active");
  std::string why;
  const auto tell = [&](const auto& response) {
    EXPECT_FALSE(response.success());
    why = response.message();
  };
  is_active_.call({}, tell, kTimeout);
  EXPECT_TRUE(wait_until([&] { return why == "the policy is shared, not autonomous"; }));
}

TEST_F(Facade, IsInactiveWhileTheRobotIsNotLocalised) {
  EXPECT_TRUE(wait_until([&] { return state_of(localiser_) == "active"; }));
  sees_nan_ = true;
  EXPECT_TRUE(wait_until([&] { return state_of(localiser_) == "inactive"; }));
  EXPECT_EQ(state_of(navigator_), "inactive");
}

TEST_F(Facade, PublishesThePoseForLateSubscribers) {
  std::optional<double> x;
  X_.x = 0.5;
  const auto pose = node_.create_subscription(
      topics::amcl_pose, [&](const auto& msg) { x = msg.pose().pose().position().x(); });
  EXPECT_TRUE(wait_until([&] { return x && is_near(*x, 0.5); }));
}

}  // namespace
}  // namespace tandem::test
