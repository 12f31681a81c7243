// SPDX-License-Identifier: Apache-2.0
// Estimates which of several goals the person is driving to, and assists toward it.
#pragma once

#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/cost_to_go.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// The places that the person may mean, and how strongly to help.
struct HindsightParams {
  std::vector<double> goals;
  double lookahead = 1.0;
  double certainty = 2.0;
  double change_of_mind = 0.05;
  double weight_user = 2.5;
  int v_samples = 9;
  int w_samples = 21;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("goals", goals, Range{-1e4, 1e4},
          "[m, m, rad] x1, y1, heading1, x2, … of the goals that the person may have");
    field("lookahead", lookahead, Range{0.1, 5.0},
          "[s] a command is rated by where it leads within this time");
    field("certainty", certainty, Range{0.0, 100.0},
          "[1/s²] rate at which a goal's log-odds fall per second of detour");
    field("change_of_mind", change_of_mind, Range{0.0, 10.0},
          "[1/s] rate at which the belief returns to a uniform distribution over the goals");
    field("weight_user", weight_user, Range{0.0, 100.0},
          "[s] cost of full disagreement with the person");
    field("v_samples", v_samples, Range{2, 101}, "number of forward speeds that are compared");
    field("w_samples", w_samples, Range{2, 101}, "number of turn rates that are compared");
  }
};

/// The assisted command and the belief over the goals behind it.
struct Assistance {
  Twist2 command;              ///< the person's own while they do not push
  std::vector<double> belief;  ///< one probability per goal, uniform at the start
};

/// Shared autonomy via hindsight optimisation (Javdani, Srinivasa, Bagnell 2015; Javdani et al.
/// 2018): the person's goal stays uncertain, and the command is the best one in expectation over
/// the belief.
///
///   V_g(X)  time to go [s]: cost-to-go / v_max + turns / ω_max. The turns lead to the direction of
///           steepest descent and, near the goal, on to its heading; at the goal only its heading
///           counts. V_g decreases along the whole path to the goal, as turning twice is never less
///           than turning once                                                                 (1)
///   Q_g(a)  V_g at the pose that the twist a reaches in `lookahead`                           (2)
///   belief  ḃ_g ∝ −certainty · b_g (Q_g(u) − min_a Q_g(a)): the person chooses u with likelihood
///           exp(−Q + V), maximum-entropy inverse optimal control (Ziebart et al. 2008)         (3)
///   command argmin_a Σ_g b_g Q_g(a) + weight_user ‖a − u‖², a, u in shares of v_max and ω_max (4)
///
/// The twists compared are scaled by the stick's deflection: a stick at rest commands rest, half
/// deflection at most half the speed. Obstacles that are not in the map are left to the planner and
/// the safety filter.
class Hindsight {
 public:
  /// Throws std::invalid_argument if a parameter is out of range, there is no goal, a goal is
  /// incomplete, or the robot cannot drive forward.
  Hindsight(const HindsightParams& params, const RobotParams& robot);

  /// Computes each goal's cost-to-go by fast marching, O(n log n) in the map's cells.
  void on_map(const StaticMap& map);
  /// Whether on_map() was called.
  [[nodiscard]] bool has_map() const { return !cost_.empty(); }
  /// The places, in M.
  [[nodiscard]] const std::vector<Pose2>& goals() const { return goals_; }

  /// Assists the person's command `user` at time `t` [s] from X_MB in the map frame. Returns `user`
  /// before the first map, for a stick at rest, and where no goal can be reached. Time that runs
  /// backwards counts as zero. Never throws.
  [[nodiscard]] Assistance assist(const Pose2& X_MB, const Twist2& user, double t);

 private:
  struct Option {
    Twist2 twist;
    std::vector<double> time_to_go;  // [s] per goal, from the pose that the twist reaches
  };

  [[nodiscard]] double vigour(const Twist2& user) const;
  [[nodiscard]] double time_to_go(std::size_t goal, const Pose2& X_MB) const;
  [[nodiscard]] std::vector<Option> options(const Pose2& X_MB, const Twist2& user) const;
  void learn(const std::vector<Option>& options, double dt);
  [[nodiscard]] Twist2 best(const std::vector<Option>& options) const;

  HindsightParams params_;
  RobotParams robot_;
  double radius_;  // [m] of the disc for which paths are computed
  std::vector<Pose2> goals_;
  std::vector<CostToGo> cost_;  // one per goal; empty before the first map
  std::vector<double> belief_;
  double last_ = -1e9;  // [s]
};

}  // namespace tandem
