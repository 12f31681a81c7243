// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/clearance_check.hpp"

#include <algorithm>
#include <cmath>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kLookAhead = 0.08;  // [m] measured beyond what is required, to skip checks later

}  // namespace

bool stays_clear(const Motion& motion, const Pose2& X_MB, const Body& body, const StaticMap& map,
                 const RequiredClearance& required) {
  Pose2 X = X_MB;
  double need = required.level;  // (1)
  double budget = 0.0;           // travel that needs no check
  for (const auto& [twist, dt] : motion) {
    const WheelSpeeds rims = to_wheels(twist, body.wheel_separation);
    const double speed = std::abs(twist.v) + body.radius * std::abs(twist.w);
    const double growth = required.per_rim * (std::abs(rims.left) + std::abs(rims.right)) +
                          required.per_path * std::abs(twist.v);
    const double rate = speed + growth;  // how fast clearance in hand is used up
    for (double rest = dt; rest > 0.0;) {
      if (rate * rest <= budget) {
        X = integrate(X, twist, rest);
        need += growth * rest;
        budget -= rate * rest;
        break;
      }
      const double step = std::min(rest, std::max(budget, kCheckSpacing) / rate);
      X = integrate(X, twist, step);
      need += growth * step;
      rest -= step;
      const double in_hand = map.clearance(body.footprint, X, need + kLookAhead) - need;
      if (in_hand < 0.0) return false;
      budget = in_hand;
    }
  }
  return true;
}

}  // namespace tandem
