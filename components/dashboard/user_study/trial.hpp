// SPDX-License-Identifier: Apache-2.0
// In: what a page wants measured, and what the robot does meanwhile. Out: a trial's measures, by
// the definitions of metrics.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tandem/dashboard/user_study/user_study.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// `id`: the page's own, which it is told again.
struct TrialRequest {
  std::int64_t id = 0;
  UserTrial asked;
  std::optional<RegionGoal> region = {};  ///< of task 2: the trial ends there
};

/// Throws std::invalid_argument for what is none, numbers out of reason included. The region is
/// [x0, y0, x1, y1] in M [m], or is not there.
[[nodiscard]] TrialRequest parse_trial_request(std::string_view json);

/// Measures one trial. It begins with the first pose that is heard, and its time is that of the
/// robot's stamps.
class Trial {
 public:
  explicit Trial(const TrialRequest& request);

  /// Where the robot is, in M, at a time [s]. What is heard after the end changes nothing.
  void on_robot(const Pose2& X_MB, double t);
  /// A total that the simulator has counted since its own start.
  void on_collisions(std::uint64_t total) {
    sample_.collisions += static_cast<int>(collisions_.growth(total));
  }
  /// Of the outline [m]; NaN where nobody knows.
  void on_clearance(double clearance);

  /// The region was reached, or the time is over.
  [[nodiscard]] bool over() const;
  /// What was asked for, with what came of it so far.
  [[nodiscard]] UserTrial measured() const;
  /// For the page: `id`, `time` [s], `collisions`, and, once it is over, `trial`: measured().
  [[nodiscard]] std::string state() const;

 private:
  [[nodiscard]] double elapsed() const { return first_ ? sample_.t - *first_ : 0.0; }

  TrialRequest request_;
  Metrics metrics_;
  DriveSample sample_;
  std::optional<double> first_;  // time of the first sample [s]
  NodeTotal collisions_;
};

}  // namespace tandem
