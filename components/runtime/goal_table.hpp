// SPDX-License-Identifier: Apache-2.0
// In: goals, their ends, requests to cancel. Out: each goal's state and which goals to cancel; the
// state machine of rcl_action, without DDS.
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/runtime/action.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A goal that a server knows.
struct TrackedGoal {
  GoalId id;                                  ///< chosen by the client
  std::int64_t stamp = 0;                     ///< when it was accepted [ns]
  GoalStatus status = GoalStatus::kAccepted;  ///< its state
  double ended = 0.0;                         ///< when it ended [s]
};

/// The goals of one action server, in the order in which they were accepted. Times in seconds are
/// on one monotonic clock.
class TANDEM_EXPORT GoalTable {
 public:
  static constexpr std::size_t kMaxGoals = 1000;  ///< more are not accepted

  /// `result_timeout`: [s] after which an ended goal is forgotten; negative: never.
  explicit GoalTable(double result_timeout) : result_timeout_{result_timeout} {}

  /// Adds a goal. Returns false for an id that is known, and if there are kMaxGoals.
  bool accept(const GoalId& id, std::int64_t stamp);
  /// Accepted → executing. Returns false in any other state.
  bool execute(const GoalId& id);
  /// Accepted or executing → canceling. Returns false in any other state.
  bool start_canceling(const GoalId& id);
  /// → succeeded, aborted or, if it is canceling, canceled. Returns false for a goal that has ended
  /// or is unknown, and for any other transition.
  bool finish(const GoalId& id, GoalStatus status, double now);

  /// kUnknown for an id that is not in the table.
  [[nodiscard]] GoalStatus status(const GoalId& id) const;
  /// All goals.
  [[nodiscard]] const std::vector<TrackedGoal>& goals() const { return goals_; }

  /// Which goals a request to cancel asks for, and the answer if all of them are cancelled.
  struct Selection {
    CancelAnswer answer = CancelAnswer::kNone;  ///< an error if the one goal cannot be cancelled
    std::vector<TrackedGoal> goals;             ///< that can be cancelled
  };
  /// `id` alone: that goal. `stamp` [ns] alone: all goals accepted until then. Both: all of these.
  /// Neither (all zeros): all goals.
  [[nodiscard]] Selection to_cancel(const GoalId& id, std::int64_t stamp) const;

  /// Forgets the goals that ended more than the time-out ago, and returns them.
  std::vector<GoalId> expire(double now);

 private:
  [[nodiscard]] TrackedGoal* find(const GoalId& id);

  double result_timeout_;
  std::vector<TrackedGoal> goals_;
};

}  // namespace tandem::runtime
