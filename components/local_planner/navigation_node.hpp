// SPDX-License-Identifier: Apache-2.0
// The part of the planner's node that serves Nav2's actions.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tandem/io/navigation_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/local_planner/navigation_params.hpp"
#include "tandem/local_planner/plan_inputs.hpp"
#include "tandem/runtime/action_server.hpp"

namespace tandem {

/// Serves `navigate_to_pose` with method `goal` and `follow_path` with method `path`, while the
/// policy is `autonomous` and the safety filter enforces; other goals are rejected. A goal goes on
/// while the person steers. It ends, and the robot stands until there is a new one, when it is
/// reached, cancelled or replaced, or when what let it begin no longer holds.
class NavigationActions {
 public:
  static constexpr double kPeriod = 0.1;  ///< [s] between two feedbacks

  /// What it uses of the planner's node, which must outlive it.
  struct Planner {
    rt::Node& node;
    const NavigationParams& params;
    const RobotStateInput& robot;
    PlanInputs& inputs;
    std::function<Method()> method;
  };

  explicit NavigationActions(Planner planner);
  /// Actions and topics that it opens.
  [[nodiscard]] static rt::Interface interface();
  NavigationActions(const NavigationActions&) = delete;
  NavigationActions& operator=(const NavigationActions&) = delete;

  /// A goal_pose arrived, which replaces the goal of navigate_to_pose.
  void on_goal_pose();

 private:
  // The goals of one action: the one in force, and where it leads.
  template <class A>
  struct Served {
    const char* name;
    Method method;
    std::vector<Pose2> way{};  // of the goal being accepted: a pose, or a path
    rt::ServerGoal<A> goal{};  // in force
    double begun = 0.0;        // [s]
    rt::ActionServer<A> server{};
  };
  using ToPose = nav2_msgs::action::NavigateToPose;
  using AlongPath = nav2_msgs::action::FollowPath;

  template <class A>
  void serve(Served<A>& served, const rt::ActionName<A>& action);
  template <class A>
  rt::GoalAnswer consider(Served<A>& served, const typename A::Goal& goal);
  template <class A>
  void begin(Served<A>& served, rt::ServerGoal<A> goal);
  template <class A>
  void go_on(Served<A>& served);
  template <class A>
  void end(Served<A>& served, rt::GoalStatus status, int code, const std::string& why);

  [[nodiscard]] std::optional<std::vector<Pose2>> way_of(const ToPose::Goal& goal) const;
  [[nodiscard]] std::optional<std::vector<Pose2>> way_of(const AlongPath::Goal& goal) const;
  void give(const Served<ToPose>& served) const;
  void give(const Served<AlongPath>& served) const;
  [[nodiscard]] double distance_left(const Served<ToPose>& served, const Pose2& X_MB) const;
  [[nodiscard]] double distance_left(const Served<AlongPath>& served, const Pose2& X_MB) const;
  [[nodiscard]] ToPose::Feedback feedback_of(const Served<ToPose>& served,
                                             const RobotState& robot) const;
  [[nodiscard]] AlongPath::Feedback feedback_of(const Served<AlongPath>& served,
                                                const RobotState& robot) const;
  [[nodiscard]] NavigationState state() const;
  void go_on();

  Planner planner_;
  NavigationInput input_;
  Served<ToPose> to_pose_;
  Served<AlongPath> along_path_;
  rt::Timer timer_;
};

}  // namespace tandem
