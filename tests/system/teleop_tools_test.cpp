// SPDX-License-Identifier: Apache-2.0
// Plays what people's tools send, with their rates, stamps, frames, zeros and silences as their
// sources have them, to the shipped system, and checks what the robot does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kUserTimeout = 0.11;  // [s] user_timeout and nav_timeout of arbitration
constexpr double kNavTimeout = 0.5;
constexpr double kDeceleration = 1.5;      // [m/s²] a_brake of bringup/robots/mir100.yaml
constexpr double kTurnDeceleration = 3.0;  // [rad/s²] alpha_brake
constexpr double kDelays = 0.6;            // [s] of messages on a busy machine
constexpr int kUserReaders = 4;  // of cmd_vel_user: arbitration, haptics, local_planner, teleop
constexpr double kRest = 1.5;    // [s] watched after the last command

struct Sent {
  double t;  // [s] since the first
  Twist2 twist;
};
using Script = std::vector<Sent>;

Script at_rate(double rate, double from, double until, const Twist2& twist) {
  Script script;
  for (int i = 0; from + i / rate < until; ++i) script.push_back({from + i / rate, twist});
  return script;
}

Script operator+(Script first, const Script& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// One key press, then what the terminal repeats while the key is held: after 0.5 s, 30 Hz. Nothing
// is sent when the key is released.
Script held_key(double until, const Twist2& twist) {
  return Script{{0.0, twist}} + at_rate(30.0, 0.5, until, twist);
}

struct Tool {
  const char* name;
  Script script;
  Twist2 sense;              // what the robot must reach at least, with its sign
  bool stamped = false;      // TwistStamped, with the time of the computer
  const char* frame = "";    // of the stamped ones
  bool autonomous = false;   // on cmd_vel_nav, with the policy `autonomous`
  bool keeps_going = false;  // does not stand between two commands
};

constexpr Twist2 kZero{};

const std::vector<Tool>& tools() {
  const Twist2 ahead{0.5, 0.0}, back{-0.3, 0.0}, left{0.0, 1.0};
  static const std::vector<Tool> all{
      // 0.5 m/s and 1 rad/s at first; Ctrl-C sends a zero.
      {"teleop_twist_keyboard: i held, then Ctrl-C",
       held_key(2.5, ahead) + Script{{3.2, kZero}},
       {0.3, 0.0}},
      {"teleop_twist_keyboard: j held, then k",
       held_key(2.0, left) + Script{{2.01, kZero}},
       {0.0, 0.3}},
      // Arbitration's handover begins at zero, so that one command alone moves nothing.
      {"teleop_twist_keyboard: comma pressed once", {{0.0, back}}, {0.0, 0.0}},
      {.name = "teleop_twist_keyboard with stamped: true",
       .script = held_key(2.5, ahead),
       .sense = {0.3, 0.0},
       .stamped = true},
      // joy_node repeats at 20 Hz; one zero when the button is released, then nothing.
      {.name = "teleop_twist_joy",
       .script = at_rate(20.0, 0.0, 2.0, ahead) + Script{{2.05, kZero}},
       .sense = {0.3, 0.0},
       .keeps_going = true},
      {.name = "teleop_twist_joy with publish_stamped_twist: true",
       .script = at_rate(20.0, 0.0, 2.0, back) + Script{{2.05, kZero}},
       .sense = {-0.2, 0.0},
       .stamped = true,
       .frame = "teleop_twist_joy",
       .keeps_going = true},
      // 10 Hz; a single zero when the sliders are reset.
      {"rqt_robot_steering", at_rate(10.0, 0.0, 2.0, ahead) + Script{{2.05, kZero}}, {0.05, 0.0}},
      // Publishes while the button is held, nothing afterwards. Its rate is 1 Hz unless it is set,
      // as it is in bringup/views/.
      {"Foxglove's teleop panel at 1 Hz", at_rate(1.0, 0.0, 3.5, left), {0.0, 0.02}},
      {.name = "Foxglove's teleop panel at 20 Hz",
       .script = at_rate(20.0, 0.0, 2.0, left),
       .sense = {0.0, 0.3},
       .keeps_going = true},
      // 20 Hz; one zero when the goal is reached or cancelled.
      {.name = "Nav2's controller of Jazzy",
       .script = at_rate(20.0, 0.0, 2.0, {0.26, 0.3}) + Script{{2.05, kZero}},
       .sense = {0.15, 0.15},
       .autonomous = true,
       .keeps_going = true},
      {.name = "Nav2's controller of Kilted",
       .script = at_rate(20.0, 0.0, 2.0, {0.26, -0.3}) + Script{{2.05, kZero}},
       .sense = {0.15, -0.15},
       .stamped = true,
       .frame = "base_link",
       .autonomous = true,
       .keeps_going = true},
      {.name = "Nav2's controller that dies",
       .script = at_rate(20.0, 0.0, 2.0, {0.26, 0.0}),
       .sense = {0.15, 0.0},
       .stamped = true,
       .frame = "base_link",
       .autonomous = true,
       .keeps_going = true}};
  return all;
}

// The robot's true motion at a time of the simulation.
struct Seen {
  double t;
  Twist2 twist;
};

bool stands(const Twist2& twist) { return std::abs(twist.v) < 0.03 && std::abs(twist.w) < 0.05; }

class TeleopTools : public OneComponent {
 protected:
  TeleopTools()
      : robot_{"../tandem",
               {"run", source_path("bringup/systems/teleop.yaml"), "--ros-args", "-p",
                "arbitration:policy:=manual", "-p", "dashboard:port:=0"}},
        truth_{node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
          if (const auto odometry = from_msg(msg))
            seen_.push_back({rt::to_seconds(msg.header().stamp()), odometry->twist});
        })} {}

  // Calls a service until it succeeds.
  template <class S>
  [[nodiscard]] bool succeeds(const char* name, const typename S::Request& request) {
    const auto client = node_.create_client(rt::ServiceName<S>{name});
    bool done = false, waiting = false;
    return spin_until(
        [&] {
          if (!done && !waiting) {
            waiting = true;
            client.call(
                request,
                [&](const auto& response) {
                  done = response.success();
                  waiting = false;
                },
                kTimeout);
          }
          return done;
        },
        kLongTimeout, node_);
  }

  // Puts the robot at its start and lets the tool's commands pass.
  void prepare(const Tool& tool) {
    tandem_msgs::srv::SetPolicy::Request policy;
    policy.policy(tool.autonomous ? "autonomous" : "manual");
    ASSERT_TRUE(succeeds<tandem_msgs::srv::SetPolicy>("/arbitration/set_policy", policy));
    ASSERT_TRUE(succeeds<std_srvs::srv::Trigger>("/diff_drive_sim/reset", {}));
    seen_.clear();
    ASSERT_TRUE(spin_until([&] { return !seen_.empty() && stands(seen_.back().twist); },
                           kLongTimeout, node_));
    seen_.clear();
  }

  template <class Publish>
  void play(const Script& script, Publish publish) {
    const double begin = node_.steady_now();
    for (const Sent& sent : script) {
      while (node_.steady_now() < begin + sent.t)
        node_.spin_some(begin + sent.t - node_.steady_now());
      publish(sent.twist);
    }
    ended_ = seen_.empty() ? 0.0 : seen_.back().t;
    (void)spin_until([&] { return !seen_.empty() && seen_.back().t > ended_ + kRest; },
                     kLongTimeout, node_);
  }

  void play(const Tool& tool) {
    const char* topic = tool.autonomous ? topics::cmd_vel_nav.name : topics::cmd_vel_user.name;
    const int readers = tool.autonomous ? 1 : kUserReaders;
    if (!tool.stamped) {
      const auto publisher = node_.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{topic});
      ASSERT_TRUE(spin_until([&] { return publisher.matched() >= readers; }, kLongTimeout, node_));
      return play(tool.script, [&](const Twist2& twist) { publisher.publish(to_msg(twist)); });
    }
    const auto publisher =
        node_.create_publisher(rt::Topic<geometry_msgs::msg::TwistStamped>{topic});
    ASSERT_TRUE(spin_until([&] { return publisher.matched() >= readers; }, kLongTimeout, node_));
    play(tool.script, [&](const Twist2& twist) {
      geometry_msgs::msg::TwistStamped msg;
      msg.header().stamp(node_.stamp());
      msg.header().frame_id(tool.frame);
      msg.twist(to_msg(twist));
      publisher.publish(msg);
    });
  }

  // Time from the last command until the robot stands for good [s]; 0 if it stood before.
  [[nodiscard]] double time_to_stand() const {
    double moved = ended_;
    for (const Seen& seen : seen_)
      if (!stands(seen.twist)) moved = std::max(moved, seen.t);
    return moved - ended_;
  }

  ChildProcess robot_;
  std::vector<Seen> seen_;
  double ended_ = 0.0;  // [s] simulated: the last command
  rt::Subscription truth_;
};

// Both velocities in the sense of the command, or as small as those of a standing robot.
void expect_sense(const std::vector<Seen>& all, const Twist2& sense) {
  double v = 0.0, w = 0.0;
  for (const Seen& seen : all) {
    const double along = sense.v < 0.0 ? -seen.twist.v : seen.twist.v;
    const double around = sense.w < 0.0 ? -seen.twist.w : seen.twist.w;
    EXPECT_GT(sense.v == 0.0 ? -std::abs(along) : along, -0.03) << "at " << seen.t << " s";
    EXPECT_GT(sense.w == 0.0 ? -std::abs(around) : around, -0.05) << "at " << seen.t << " s";
    v = std::max(v, along);
    w = std::max(w, around);
  }
  EXPECT_GE(v, std::abs(sense.v));
  EXPECT_GE(w, std::abs(sense.w));
}

void print(const char* tool, const std::vector<Seen>& all, double to_stand) {
  double v = 0.0, w = 0.0;
  for (const Seen& seen : all) {
    v = std::max(v, std::abs(seen.twist.v));
    w = std::max(w, std::abs(seen.twist.w));
  }
  std::printf("%-50s %.2f m/s, %.2f rad/s; stands %.2f s after the last command\n", tool, v, w,
              to_stand);
}

// Whether the robot moves from its first motion until the last command.
bool kept_going(const std::vector<Seen>& all, double until) {
  const auto first =
      std::find_if(all.begin(), all.end(), [](const Seen& seen) { return !stands(seen.twist); });
  return std::none_of(first, all.end(),
                      [&](const Seen& seen) { return seen.t < until - 0.2 && stands(seen.twist); });
}

TEST_F(TeleopTools, MoveTheRobotInTheirSenseAndLetItStandWhenTheyEnd) {
  for (const Tool& tool : tools()) {
    SCOPED_TRACE(tool.name);
    ASSERT_NO_FATAL_FAILURE(prepare(tool));
    ASSERT_NO_FATAL_FAILURE(play(tool));
    expect_sense(seen_, tool.sense);
    EXPECT_TRUE(!tool.keeps_going || kept_going(seen_, ended_));
    const double braking = std::max(0.5 / kDeceleration, 1.0 / kTurnDeceleration);
    print(tool.name, seen_, time_to_stand());
    EXPECT_LT(time_to_stand(), (tool.autonomous ? kNavTimeout : kUserTimeout) + braking + kDelays);
  }
}

}  // namespace
}  // namespace tandem::test
