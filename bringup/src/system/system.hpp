// SPDX-License-Identifier: Apache-2.0
// Runs the components of a system file, in this process or in one process each.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/component.hpp"
#include "tandem/runtime/node_thread.hpp"

namespace tandem {

/// One component of a system, as declared in the system file.
struct SystemNode {
  std::string component;
  rt::NodeOptions options{};
  std::string thread{};  ///< shared with the nodes that name the same one; empty: one of its own
  int priority = 0;      ///< real-time priority of its thread; 0: none
  bool respawn = false;  ///< restart it after it ends by itself; needs separate processes

  /// Its thread's name: that of a shared one, or its own.
  [[nodiscard]] const std::string& thread_name() const {
    return thread.empty() ? options.name : thread;
  }
};

/// Which components run, under which names, with which parameters and remappings.
struct System {
  std::string path;
  std::vector<SystemNode> nodes;
  int dds_priority = 0;  ///< real-time priority of the threads of DDS; 0: none
};

/// Throws std::invalid_argument naming file and line if the file is not a valid system file.
[[nodiscard]] System load_system(const std::string& path);

/// Throws std::invalid_argument if `only` contains a name that no node of the system has.
void require_names(const System& system, const std::vector<std::string>& only);

/// The components of a system, on the threads that it names. Destruction stops them.
class RunningSystem {
 public:
  /// Runs the nodes named in `only` (all if empty). Throws std::invalid_argument for a name that
  /// the system does not have, and whatever a component's constructor throws; then nothing runs.
  explicit RunningSystem(const System& system, const std::vector<std::string>& only = {});

  void stop();  ///< returns at once
  void wait();  ///< until every component has stopped

 private:
  std::vector<rt::RunningComponent> components_;
  std::vector<std::unique_ptr<rt::NodeThread>> threads_;
};

/// Runs a system until SIGINT or SIGTERM; the result is the program's exit status.
/// `separate_processes`: one process per component, started as `<this program> run FILE --only
/// NAME`. With security enabled each is in the enclave of its node's full name, unless an enclave
/// is set for all.
int run_system(const std::string& path, const std::vector<std::string>& only,
               bool separate_processes, const std::vector<std::string>& ros_args);

}  // namespace tandem
