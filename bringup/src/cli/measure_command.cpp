// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/measure_command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/metrics/step_response.hpp"
#include "tandem/runtime/decode.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;

struct MeasureRequest {
  std::string recording, cmd_vel = "/cmd_vel", odom = "/odom";
};

struct Axes {
  std::vector<Stamped<double>> v, w;  // [m/s], [rad/s]; time of arrival [s]

  void add(const Twist& twist, double t) {
    v.push_back({twist.linear().x(), t});
    w.push_back({twist.angular().z(), t});
  }
};

// Times are from the first message on, because a double cannot resolve a drive since 1970.
struct Recorded {
  Axes commands, odometry;
  double oldest = 0.0;       // greatest age of odometry on arrival [s]
  double age_sum = 0.0;      // [s]
  bool clocks_agree = true;  // whether each age is plausible
};

// The topic's index; throws if it is missing.
std::size_t index_of(const BagReader& bag, const std::string& topic,
                     const MeasureRequest& request) {
  for (std::size_t i = 0; i < bag.topics().size(); ++i)
    if (bag.topics()[i].name == topic) return i;
  throw std::runtime_error(request.recording + ": contains no " + topic +
                           "; record it, or name the topic with --cmd-vel or --odom");
}

template <class M>
std::optional<M> decoded(const BagMessage& message) {
  M value;
  if (!rt::decode(rt::type_ref<M>(), message.bytes, &value)) return std::nullopt;
  return value;
}

void take_command(const BagMessage& message, const std::string& type, double t, Recorded& all) {
  if (type == rt::type_ref<TwistStamped>().name) {
    if (const auto stamped = decoded<TwistStamped>(message)) all.commands.add(stamped->twist(), t);
  } else if (const auto twist = decoded<Twist>(message)) {
    all.commands.add(*twist, t);
  }
}

void take_odometry(const BagMessage& message, double t, Recorded& all) {
  constexpr double kMaxAge = 1.0;  // [s]; a greater one shows that the clocks differ
  const auto odometry = decoded<nav_msgs::msg::Odometry>(message);
  if (!odometry) return;
  all.odometry.add(odometry->twist().twist(), t);
  const auto& stamp = odometry->header().stamp();
  const std::int64_t taken = stamp.sec() * std::int64_t{1'000'000'000} + stamp.nanosec();
  const double age = 1e-9 * static_cast<double>(message.time - taken);
  all.clocks_agree = all.clocks_agree && age >= 0.0 && age < kMaxAge;
  all.oldest = std::max(all.oldest, age);
  all.age_sum += age;
}

Recorded read(const MeasureRequest& request) {
  BagReader bag{request.recording};
  const std::size_t cmd_vel = index_of(bag, request.cmd_vel, request);
  const std::size_t odom = index_of(bag, request.odom, request);
  Recorded all;
  std::optional<std::int64_t> first;
  BagMessage message;
  while (bag.next(message)) {
    if (!first) first = message.time;
    const double t = 1e-9 * static_cast<double>(message.time - *first);
    if (message.topic == cmd_vel) take_command(message, bag.topics()[cmd_vel].type, t, all);
    if (message.topic == odom) take_odometry(message, t, all);
  }
  return all;
}

double largest_gap(const std::vector<Stamped<double>>& signal) {
  double gap = 0.0;
  for (std::size_t i = 1; i < signal.size(); ++i)
    gap = std::max(gap, signal[i].t - signal[i - 1].t);
  return gap;
}

double rate(const std::vector<Stamped<double>>& signal) {
  if (signal.size() < 2 || signal.back().t <= signal.front().t) return 0.0;
  return static_cast<double>(signal.size() - 1) / (signal.back().t - signal.front().t);
}

void print_axis(const char* name, const char* unit, const std::optional<StepResponse>& response) {
  if (!response) {
    std::printf("%-8s not measured: record steps of the command, from zero to full and back\n",
                name);
    return;
  }
  std::printf("%-8s %7.3f s %7.3f s", name, response->delay, response->lag);
  if (response->stops > 0)
    std::printf("  %6.2f %-7s %5d", response->braking, unit, response->stops);
  else
    std::printf("  %-14s %5d", "no stop", 0);
  constexpr double kUnbounded = 50.0;  // [m/s²], [rad/s²]; no base accelerates like that
  if (response->a_up < kUnbounded)
    std::printf("  %6.2f %-7s", response->a_up, unit);
  else
    std::printf("  %-14s", "no bound");
  std::printf("  %5.1f %%\n", 100.0 * response->residual);
}

void print_parameters(const Recorded& all, const std::optional<StepResponse>& v,
                      const std::optional<StepResponse>& w) {
  const double delay = std::max(v ? v->delay : 0.0, w ? w->delay : 0.0);
  const double lag = std::max(v ? v->lag : 0.0, w ? w->lag : 0.0);
  const auto count = static_cast<double>(all.odometry.v.size());
  const double age = all.clocks_agree ? all.age_sum / count : 0.0;
  std::printf("\n/**:\n  ros__parameters:\n");
  if (v && v->stops > 0) std::printf("    a_brake: %.2f\n", v->braking);
  if (w && w->stops > 0) std::printf("    alpha_brake: %.2f\n", w->braking);
  std::printf("    motor_lag: %.3f\n    command_delay: %.3f\n", lag, std::max(0.0, delay - age));
  if (all.clocks_agree)
    std::printf("    sensor_delay: %.3f\n", all.oldest);
  else
    std::printf(
        "    # sensor_delay: unknown, because the clocks of odometry and recorder differ\n");
  std::printf("local_planner:\n  ros__parameters:\n    delay: %.3f\n", delay + lag);
}

void run(const MeasureRequest& request) {
  const Recorded all = read(request);
  const auto v = step_response(all.commands.v, all.odometry.v);
  const auto w = step_response(all.commands.w, all.odometry.w);
  std::printf("%s: %zu, %.1f Hz. %s: %zu, %.1f Hz, largest gap %.3f s.\n\n",
              request.cmd_vel.c_str(), all.commands.v.size(), rate(all.commands.v),
              request.odom.c_str(), all.odometry.v.size(), rate(all.odometry.v),
              largest_gap(all.odometry.v));
  if (!v && !w)
    throw std::runtime_error(request.recording +
                             ": the commands hardly change; record steps from zero to full speed "
                             "and back, forward and turning");
  std::printf("%-8s %9s %9s  %-14s %5s  %-14s  %7s\n", "axis", "delay", "lag", "braking", "stops",
              "speeds up", "error");
  print_axis("forward", "m/s²", v);
  print_axis("turning", "rad/s²", w);
  print_parameters(all, v, w);
}

}  // namespace

void add_measure_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "measure", "Measure a base's delays and braking from a recording of steps");
  auto request = std::make_shared<MeasureRequest>();
  command
      ->add_option("recording", request->recording,
                   "recording of `tandem record` or `ros2 bag record` with cmd_vel and odom")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--cmd-vel", request->cmd_vel, "topic of the commands (Twist, TwistStamped)")
      ->capture_default_str();
  command->add_option("--odom", request->odom, "topic of the odometry")->capture_default_str();
  command->footer(
      "Prints the lines for the robot's file. `delay`: from sending a command to the arrival of "
      "its "
      "first effect; `lag`: the motors' time constant; `braking`: the least mean deceleration "
      "between 90 % and 10 % of the speed; `speeds up`: the largest acceleration; `error`: what "
      "the "
      "model leaves over. The safety filter needs the worst values: repeat it with full load and "
      "on "
      "the worst floor.");
  command->callback([request] { run(*request); });
}

}  // namespace tandem
