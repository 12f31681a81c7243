// SPDX-License-Identifier: Apache-2.0
#include "tandem/haptics/haptics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

double share(double value) { return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0; }

}  // namespace

Haptics::Haptics(const HapticsParams& params) : params_{params} { check(params_); }

double Haptics::feel(const std::optional<Twist2>& user, const Twist2& robot, double clearance,
                     double dt) {
  if (!user || (user->v == 0.0 && user->w == 0.0)) {
    apart_.reset();
    return 0.0;
  }
  return std::max(disagreement(*user, robot, dt), share(1.0 - clearance / params_.near));
}

double Haptics::disagreement(const Twist2& user, const Twist2& robot, double dt) {
  const double apart = std::hypot(user.v - robot.v, user.w - robot.w);
  const auto before = std::exchange(apart_, apart);
  if (!before) return 0.0;  // not known yet whether it decreases
  const double closing = std::max(0.0, (*before - apart) / dt);
  const double left = (apart - kAhead * closing) / params_.disagreement;
  return share((left - params_.deadband) / (1.0 - params_.deadband));
}

}  // namespace tandem
