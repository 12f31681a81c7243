// SPDX-License-Identifier: Apache-2.0
// Lists the numeric fields of a message, so that a test can set each to a non-finite value.
#pragma once

#include <functional>
#include <limits>
#include <vector>

namespace tandem::test {

inline constexpr double kNotFinite[] = {std::numeric_limits<double>::quiet_NaN(),
                                        std::numeric_limits<double>::infinity(),
                                        -std::numeric_limits<double>::infinity()};

/// Each entry sets one numeric field of a message.
template <class M>
using Setters = std::vector<std::function<void(M&, double)>>;

/// The fields of the Twist that `twist` finds in a message.
template <class M, class TwistOf>
Setters<M> twist_numbers(TwistOf twist) {
  return {[=](M& m, double x) { twist(m).linear().x(x); },
          [=](M& m, double x) { twist(m).linear().y(x); },
          [=](M& m, double x) { twist(m).linear().z(x); },
          [=](M& m, double x) { twist(m).angular().x(x); },
          [=](M& m, double x) { twist(m).angular().y(x); },
          [=](M& m, double x) { twist(m).angular().z(x); }};
}

/// The fields of the Pose that `pose` finds in a message.
template <class M, class PoseOf>
Setters<M> pose_numbers(PoseOf pose) {
  return {[=](M& m, double x) { pose(m).position().x(x); },
          [=](M& m, double x) { pose(m).position().y(x); },
          [=](M& m, double x) { pose(m).position().z(x); },
          [=](M& m, double x) { pose(m).orientation().x(x); },
          [=](M& m, double x) { pose(m).orientation().y(x); },
          [=](M& m, double x) { pose(m).orientation().z(x); },
          [=](M& m, double x) { pose(m).orientation().w(x); }};
}

}  // namespace tandem::test
