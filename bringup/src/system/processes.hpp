// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace tandem {

/// A process that runs this program.
struct ProcessPlan {
  std::string name;                    ///< as the log calls it
  std::vector<std::string> arguments;  ///< after the program's name
  /// Whether it restarts after ending by itself, except after exiting early on its first start.
  bool respawn = false;
  std::vector<std::string> respawn_arguments;  ///< appended to `arguments` at every restart
};

/// Delay before a process restarts [s]: twice `last`, the delay before its previous start (0 for
/// the first start), clamped to [0.5, 30]; 0.5 again if it ran for `life` ≥ 60 [s].
[[nodiscard]] double respawn_delay(double last, double life);

/// Child processes that run this program. No child outlives this process, however it ends.
class Processes {
 public:
  Processes() = default;
  ~Processes();  ///< SIGTERM for all that are left, SIGKILL two seconds later, and reaped
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  /// Throws std::runtime_error if the process cannot be created.
  void start(const ProcessPlan& plan);

  /// Watches the children until a shutdown (SIGINT, SIGTERM) or until none is left; each death is
  /// logged, the others run on, and those that respawn start again after respawn_delay(). Tells the
  /// service manager that the processes were started, and every second that this one is alive. The
  /// exit status: 0 after a shutdown, 1 if one died by itself.
  int run();

 private:
  struct Child {
    ProcessPlan plan;
    pid_t pid;
    double start;  // [s] steady
    double delay;  // [s] before that start
  };
  struct Pending {
    ProcessPlan plan;
    double start;
    double delay;
  };

  void launch(const ProcessPlan& plan, const std::vector<std::string>& arguments, double delay);
  void reap(bool expected);
  [[nodiscard]] static bool failed_at_once(const Child& child, int status);
  void plan_respawn(const Child& child, const std::string& how);
  void start_pending();

  std::vector<Child> children_;
  std::vector<Pending> pending_;  // waiting to restart
  bool died_ = false;             // a child ended by itself
};

}  // namespace tandem
