// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/handover.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

// The value nearest to `value` that is not faster than `target` and does not have the opposite
// sign.
double between_rest_and(double target, double value) {
  return std::clamp(value, std::min(0.0, target), std::max(0.0, target));
}

}  // namespace

// The components are not scaled together, although that would keep the chosen arc: a robot that
// goes straight would then halt at every handover to a command that turns, because its yaw rate
// starts at zero. A driver expects the speed to be kept. The arc differs from the chosen one during
// the ramp.
Twist2 Handover::follow(const Twist2& chosen, bool changed, double now) {
  return {v_.follow(chosen.v, changed, now, duration_),
          w_.follow(chosen.w, changed, now, duration_)};
}

double Handover::Ramp::follow(double target, bool changed, double now, double duration) {
  const double reached = between_rest_and(target, value);
  const double growth = std::abs(target - reached);
  if (changed) start(growth, now, duration);
  if (now >= end || growth == 0.0) return finish(target, now);
  const double dt = now - time;
  // The second term reaches a growing target in time, too.
  const double step = std::max(pace * (dt / duration), growth * (dt / (end - time)));
  if (step >= growth) return finish(target, now);
  time = now;
  return value = between_rest_and(target, reached + std::copysign(step, target));
}

void Handover::Ramp::start(double growth, double now, double duration) {
  const bool running = time < end;
  pace = running ? std::max(pace, growth) : growth;
  if (!running) time = now;
  end = now + duration;
}

double Handover::Ramp::finish(double target, double now) {
  time = end = now;
  return value = target;
}

}  // namespace tandem
