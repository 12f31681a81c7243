// SPDX-License-Identifier: Apache-2.0
// Measures one trial of a user study, by the definitions of metrics.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tandem/dashboard/user_study/user_study.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// A page's request for a trial. `id`: chosen by the page, returned in the trial's state.
struct TrialRequest {
  std::int64_t id = 0;
  UserTrial asked;
  std::optional<RegionGoal> region = {};  ///< of task 2; the trial ends in it
};

/// Throws std::invalid_argument for malformed requests, including numbers out of range. The
/// optional region is [x0, y0, x1, y1] in M [m].
[[nodiscard]] TrialRequest parse_trial_request(std::string_view json);

/// Measures one trial. It begins with the first pose received; its time is that of the robot's
/// stamps.
class Trial {
 public:
  explicit Trial(const TrialRequest& request);

  /// The robot's pose in M at a time [s]. Poses after the end are ignored.
  void on_robot(const Pose2& X_MB, double t);
  /// The simulator's total of collisions since its own start.
  void on_collisions(std::uint64_t total) {
    sample_.collisions += static_cast<int>(collisions_.growth(total));
  }
  /// Clearance of the outline [m]; NaN if unknown.
  void on_clearance(double clearance);

  /// Whether the region was reached or the time is over.
  [[nodiscard]] bool over() const;
  /// The request with the results so far.
  [[nodiscard]] UserTrial measured() const;
  /// JSON for the page: `id`, `time` [s], `collisions`, and, once the trial is over, `trial`:
  /// measured().
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
