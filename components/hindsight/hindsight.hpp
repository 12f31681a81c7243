// SPDX-License-Identifier: Apache-2.0
// In: the person's command and the places they may be going to. Out: where they seem to go, and the
// command that helps.
#pragma once

#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/cost_to_go.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

struct HindsightParams {
  std::vector<double> goals;
  double lookahead = 1.0;
  double certainty = 2.0;
  double change_of_mind = 0.05;
  double weight_user = 2.5;
  double heading_distance = 0.5;
  int v_samples = 9;
  int w_samples = 21;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("goals", goals, Range{-1e4, 1e4},
          "[m, m, rad] x1, y1, heading1, x2, … of the places people go to here");
    field("lookahead", lookahead, Range{0.1, 5.0}, "[s] a command is judged by where it leads in");
    field("certainty", certainty, Range{0.0, 100.0},
          "[1/s²] the log of a goal's odds falls so fast for each second of detour");
    field("change_of_mind", change_of_mind, Range{0.0, 10.0},
          "[1/s] share of the belief that goes back to all goals alike");
    field("weight_user", weight_user, Range{0.0, 100.0},
          "[s] of full disagreement with the person");
    field("heading_distance", heading_distance, Range{0.05, 5.0},
          "[m] from a goal its heading begins to count more than the way there");
    field("v_samples", v_samples, Range{2, 101}, "forward speeds that are compared");
    field("w_samples", w_samples, Range{2, 101}, "turn rates that are compared");
  }
};

/// The command that helps, and the belief it came from.
struct Assistance {
  Twist2 command;
  std::vector<double> belief;  ///< one probability for each goal; uniform where nothing is known
};

/// Shared autonomy via hindsight optimisation (Javdani, Srinivasa, Bagnell 2015; Javdani et al.
/// 2018): which goal the person has in mind stays uncertain, and the command is the best on average
/// over the belief.
///
///   V_g(X)  time to go: cost-to-go / v_max + turns / ω_max: to the way downhill and, once the goal
///           comes, from there to its heading; on the spot to its heading alone. Falls on the way
///           to the goal everywhere, as turning twice is never less than turning once           (1)
///   Q_g(a)  V_g where the twist a leads to in `lookahead`                                     (2)
///   belief  ḃ_g ∝ −certainty · b_g (Q_g(u) − min_a Q_g(a)): the person chooses u with likelihood
///           exp(−Q + V), maximum-entropy inverse optimal control (Ziebart et al. 2008)         (3)
///   command argmin_a Σ_g b_g Q_g(a) + weight_user ‖a − u‖², a in shares of the fastest        (4)
///
/// The twists compared are as vigorous as the person's, so a stick at rest rests and half a stick
/// is half the speed. What stands in the way is left to the planner and the filter behind.
class Hindsight {
 public:
  /// Throws std::invalid_argument on parameters out of range, no goal, an incomplete one,
  /// and a robot that does not drive forward.
  Hindsight(const HindsightParams& params, const RobotParams& robot);

  /// One fast marching per goal.
  void on_map(const StaticMap& map);
  [[nodiscard]] bool has_map() const { return !cost_.empty(); }
  [[nodiscard]] const std::vector<Pose2>& goals() const { return goals_; }

  /// The person's command at `t` [s], one clock that does not go back. Before the first map, and
  /// from where no way leads to any goal, the person's own command. Never throws.
  [[nodiscard]] Assistance assist(const Pose2& X_MB, const Twist2& user, double t);

 private:
  struct Option {
    Twist2 twist;
    std::vector<double> time_to_go;  // [s] per goal, after it
  };

  [[nodiscard]] double vigour(const Twist2& user) const;
  [[nodiscard]] double time_to_go(std::size_t goal, const Pose2& X_MB) const;
  [[nodiscard]] std::vector<Option> options(const Pose2& X_MB, const Twist2& user) const;
  void learn(const std::vector<Option>& options, double dt);
  [[nodiscard]] Twist2 best(const std::vector<Option>& options) const;

  HindsightParams params_;
  RobotParams robot_;
  double radius_;  // [m] of the disc whose way is the robot's
  std::vector<Pose2> goals_;
  std::vector<CostToGo> cost_;  // one for each goal, once there is a map
  std::vector<double> belief_;
  double last_ = -1e9;  // [s]
};

}  // namespace tandem
