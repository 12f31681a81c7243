// SPDX-License-Identifier: Apache-2.0
// Computes how strongly the stick should resist the person, from the person's command, the robot's
// command and the clearance (Devalla 2020, future work).
#pragma once

#include <optional>

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The clearance and the disagreement that the stick resists.
struct HapticsParams {
  double near = 0.4;
  double disagreement = 0.5;
  double deadband = 0.15;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("near", near, Range{0.01, 10.0}, "[m] clearance below which proximity is felt");
    field("disagreement", disagreement, Range{0.01, 10.0},
          "[m/s, rad/s] disagreement between person and robot that gives full strength");
    field("deadband", deadband, Range{0.0, 0.99},
          "[1] fraction of the disagreement that is not felt, because the planner never agrees "
          "exactly");
  }
};

/// Computes the resistance of the stick. Call at a steady rate.
class Haptics {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit Haptics(const HapticsParams& params);

  /// The resistance in [0, 1], `dt` [s] after the last call: the larger of the disagreement beyond
  /// the deadband and the nearness, 1 − clearance / near. Disagreement is |user − robot|
  /// extrapolated to kAhead from now at the rate at which it is decreasing, so that a robot that is
  /// merely still accelerating does not count as disagreeing. `user`: the person's command while
  /// they push; nullopt gives 0. Values that are not finite are ignored.
  [[nodiscard]] double feel(const std::optional<Twist2>& user, const Twist2& robot,
                            double clearance, double dt);

  static constexpr double kAhead = 1.0;  ///< [s]

 private:
  [[nodiscard]] double disagreement(const Twist2& user, const Twist2& robot, double dt);

  HapticsParams params_;
  std::optional<double> apart_;  // |user − robot| at the last call; nullopt: no push
};

}  // namespace tandem
