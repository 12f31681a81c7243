// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/deadlock.hpp"

#include <cmath>

namespace tandem {
namespace {

constexpr double kPatience = 0.6;  // [s] of refused plans
constexpr double kYields = 1.5;    // [s] of passing the person's command through
constexpr double kStands = 0.005;  // [m/s, rad/s]

bool stands(const Twist2& twist) {
  return std::abs(twist.v) < kStands && std::abs(twist.w) < kStands;
}

}  // namespace

bool Deadlock::holds(bool refused, const Twist2& measured, double t) {
  refused = refused && stands(measured);
  if (!refused || t < refused_since_) refused_since_ = -1.0;
  if (refused && refused_since_ < 0.0) refused_since_ = t;
  if (refused && t - refused_since_ >= kPatience) {
    until_ = t + kYields;
    refused_since_ = -1.0;
  }
  return t < until_ && until_ - t <= kYields;
}

}  // namespace tandem
