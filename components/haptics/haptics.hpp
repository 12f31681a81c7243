// SPDX-License-Identifier: Apache-2.0
// In: what the person asks for, what the robot is told, how near the next obstacle is. Out: how
// strongly the stick should resist (Devalla 2020, future work).
#pragma once

#include <optional>

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

struct HapticsParams {
  double near = 0.4;
  double disagreement = 0.5;
  double deadband = 0.15;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("near", near, Range{0.01, 10.0}, "[m] clearance below which nearness is felt");
    field("disagreement", disagreement, Range{0.01, 10.0},
          "[m/s, rad/s] between person and robot that is felt in full");
    field("deadband", deadband, Range{0.0, 0.99},
          "[1] part of the disagreement that is not felt: the planner is never quite of one mind");
  }
};

/// What the person feels. Call at a steady rate.
class Haptics {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit Haptics(const HapticsParams& params);

  /// The resistance in [0, 1], `dt` [s] after the last: the larger of disagreement beyond the
  /// deadband and nearness, 1 − clearance / near. Disagreement is how far |user − robot| would be
  /// from zero kAhead from now if it went on closing as it does: a robot that only takes its time
  /// to speed up is of the person's mind. `user`: the person's command, if they push; who lets go
  /// feels nothing. What is not finite is not felt.
  [[nodiscard]] double feel(const std::optional<Twist2>& user, const Twist2& robot,
                            double clearance, double dt);

  static constexpr double kAhead = 1.0;  // [s]

 private:
  [[nodiscard]] double disagreement(const Twist2& user, const Twist2& robot, double dt);

  HapticsParams params_;
  std::optional<double> apart_;  // at the last call; none: nobody pushed
};

}  // namespace tandem
