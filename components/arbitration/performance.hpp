// SPDX-License-Identifier: Apache-2.0
// Measures how well the person drives, from the person's and the planner's commands, and derives
// the planner's share from it.
#pragma once

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Parameters of policy `adaptive`; may change while the robot drives.
struct AdaptiveParams {
  double base = 0.3;
  double range = 0.7;
  double time = 3.0;
  double unsteady = 4.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("adaptive_base", base, Range{0.0, 1.0}, "[1] planner's share with a perfect driver");
    field("adaptive_range", range, Range{0.0, 1.0},
          "[1] share added as performance falls to 0; at most 1 in total");
    field("adaptive_time", time, Range{0.1, 300.0}, "[s] averaging time of performance");
    field("adaptive_unsteady", unsteady, Range{0.1, 1000.0},
          "[m/s², rad/s²] mean rate of change of the person's command that counts as no control at "
          "all");
  }
};

/// Performance P of the person, 0 … 1, and the planner's share K:
///
///   p = (1 − min(1, |u_user − u_planner| / disagreement))
///       (1 − min(1, |u̇_user| / unsteady))                               (1)
///   P = p averaged over `time`, while the person steers                  (2)
///   K = base + range (1 − P), at most 1, moved only by more than 0.1            (3)
///
/// (3) is the wheelchair's rule K = K0 + Kr (1 − performance); (1) is our own measure: a person
/// drives well if the planner does not need to correct the command and the hand is steady.
class Performance {
 public:
  /// Takes the person's command at time t [s].
  void on_user(const Twist2& user, double t, const AdaptiveParams& params);
  /// Updates P from the current agreement of both commands. `disagreement`: difference that counts
  /// as complete [m/s, rad/s].
  void update(const Twist2& shared, double disagreement, double t, const AdaptiveParams& params);

  /// How well the person drives, 0 … 1.
  [[nodiscard]] double performance() const { return performance_; }
  /// The planner's share, (3).
  [[nodiscard]] double share(const AdaptiveParams& params) const;

 private:
  Stamped<Twist2> user_;
  double time_ = -1.0;
  double change_ = 0.0;  // mean of |u̇_user|
  double performance_ = 1.0;
  double held_ = 1.0;  // performance with hysteresis, from which the share is computed
};

}  // namespace tandem
