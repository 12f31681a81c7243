// SPDX-License-Identifier: Apache-2.0
#include "tandem/hindsight/hindsight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kAtRest = 0.02;          // [1] a smaller deflection counts as a stick at rest
constexpr double kLongestStep = 0.2;      // [s] longest time that one sample counts for
constexpr double kMaxDetour = 3.0;        // [s] limits the evidence of one sample against a goal
constexpr double kCellSlack = 0.08;       // [m] by which a map may underestimate distances
constexpr double kHeadingDistance = 0.5;  // [m] from a goal, where its heading begins to count

double square(double x) { return x * x; }

std::vector<Pose2> poses(const std::vector<double>& numbers) {
  if (numbers.empty() || numbers.size() % 3 != 0)
    throw std::invalid_argument("goals: expected x1, y1, heading1, x2, … of at least one goal");
  std::vector<Pose2> all;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    all.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return all;
}

}  // namespace

Hindsight::Hindsight(const HindsightParams& params, const RobotParams& robot)
    : params_{params}, robot_{robot}, goals_{poses(params.goals)} {
  check(params_);
  check(robot_);
  if (robot_.v_max <= 0.0)
    throw std::invalid_argument(
        "v_max must be positive: a robot that cannot drive forward reaches no goal");
  const Footprint outline = footprint_of(robot_);
  double low = 0.0, high = 0.0;
  for (const auto& part : outline.parts)
    for (const auto& p_BV : part) {
      low = std::min(low, p_BV.y());
      high = std::max(high, p_BV.y());
    }
  radius_ = std::max(0.0, std::min(-low, high) - kCellSlack);
  belief_.assign(goals_.size(), 1.0 / static_cast<double>(goals_.size()));
}

void Hindsight::on_map(const StaticMap& map) {
  cost_.clear();
  for (const Pose2& X_MG : goals_) cost_.emplace_back(map, X_MG.position(), radius_);
}

Assistance Hindsight::assist(const Pose2& X_MB, const Twist2& user, double t) {
  const double dt = std::clamp(t - last_, 0.0, kLongestStep);
  last_ = t;
  if (!has_map() || vigour(user) < kAtRest) return {user, belief_};
  const std::vector<Option> all = options(X_MB, user);
  const auto& own = all.front().time_to_go;
  if (std::all_of(own.begin(), own.end(), [](double s) { return std::isinf(s); }))
    return {user, belief_};
  learn(all, dt);
  return {best(all), belief_};
}

// The twist's share of the robot's limits, 0 … 1.
double Hindsight::vigour(const Twist2& user) const {
  const double fastest = user.v < 0.0 ? -robot_.v_min : robot_.v_max;
  const double v = fastest > 0.0 ? std::abs(user.v) / fastest : 0.0;
  return std::min(1.0, std::max(v, std::abs(user.w) / robot_.w_max));
}

// (1)
double Hindsight::time_to_go(std::size_t goal, const Pose2& X_MB) const {
  const double cost = cost_[goal].at(X_MB.position());
  if (std::isinf(cost)) return cost;
  const double way = cost_[goal].downhill(X_MB.position()), end = goals_[goal].theta;
  const double there = std::clamp(1.0 - cost / kHeadingDistance, 0.0, 1.0);
  // The final turn fades in once the remaining drive takes less time than half a turn.
  const double comes = std::max(0.0, 1.0 - cost * robot_.w_max / (std::numbers::pi * robot_.v_max));
  const double turns =
      std::abs(wrap_angle(way - X_MB.theta)) + comes * std::abs(wrap_angle(end - way));
  const double last = std::abs(wrap_angle(end - X_MB.theta));
  return cost / robot_.v_max + ((1.0 - there) * turns + there * last) / robot_.w_max;
}

// (2). The first option is the person's own twist.
std::vector<Hindsight::Option> Hindsight::options(const Pose2& X_MB, const Twist2& user) const {
  std::vector<Option> all;
  const auto add = [&](const Twist2& twist) {
    Option option{twist, {}};
    const Pose2 X = integrate(X_MB, twist, params_.lookahead);
    for (std::size_t g = 0; g < goals_.size(); ++g) option.time_to_go.push_back(time_to_go(g, X));
    all.push_back(std::move(option));
  };
  add(limit(user, robot_));
  const double share = vigour(user);
  const double slowest = share * robot_.v_min, fastest = share * robot_.v_max;
  const double turn = share * robot_.w_max;
  for (int i = 0; i < params_.v_samples; ++i)
    for (int j = 0; j < params_.w_samples; ++j)
      add({slowest + (fastest - slowest) * i / (params_.v_samples - 1),
           turn * (2.0 * j / (params_.w_samples - 1) - 1.0)});
  return all;
}

// (3)
void Hindsight::learn(const std::vector<Option>& options, double dt) {
  for (std::size_t g = 0; g < goals_.size(); ++g) {
    double least = options.front().time_to_go[g];
    for (const Option& option : options) least = std::min(least, option.time_to_go[g]);
    const double detour = std::isinf(least) ? kMaxDetour : options.front().time_to_go[g] - least;
    belief_[g] *= std::exp(-params_.certainty * std::min(detour, kMaxDetour) * dt);
  }
  const double sum = std::accumulate(belief_.begin(), belief_.end(), 0.0);
  const double back = std::min(1.0, params_.change_of_mind * dt);
  const double alike = 1.0 / static_cast<double>(goals_.size());
  for (double& b : belief_) b = sum > 0.0 ? (1.0 - back) * b / sum + back * alike : alike;
}

// (4). Unreachable goals are left out: their infinite time to go would make every cost infinite.
Twist2 Hindsight::best(const std::vector<Option>& options) const {
  const Twist2 user = options.front().twist;
  Twist2 best = user;
  std::vector<bool> reachable(goals_.size(), false);
  for (const Option& option : options)
    for (std::size_t g = 0; g < goals_.size(); ++g)
      if (std::isfinite(option.time_to_go[g])) reachable[g] = true;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [twist, time_to_go] : options) {
    double cost = params_.weight_user * (square((twist.v - user.v) / robot_.v_max) +
                                         square((twist.w - user.w) / robot_.w_max));
    for (std::size_t g = 0; g < goals_.size(); ++g)
      if (reachable[g]) cost += belief_[g] * time_to_go[g];
    if (cost >= least) continue;
    least = cost;
    best = twist;
  }
  return best;
}

}  // namespace tandem
