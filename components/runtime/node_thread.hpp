// SPDX-License-Identifier: Apache-2.0
// A thread that spins nodes.
#pragma once

#include <string>
#include <thread>
#include <vector>

#include "tandem/runtime/node.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Spins one or more nodes on DDS on a thread of its own. The callbacks of all its nodes run one
/// after another: a message between two of them needs no change of threads, and a long callback of
/// one delays the others. An exception in a callback ends the process, so that the timeouts of
/// downstream nodes stop the robot.
class TANDEM_EXPORT NodeThread {
 public:
  /// Begins to spin `nodes`, which must outlive it. `name` is the thread's in `top -H`;
  /// `priority`: see use_real_time(), 0: none. Throws std::invalid_argument if there is a node on a
  /// LocalBus, which the bus runs.
  NodeThread(const std::string& name, const std::vector<Node*>& nodes, int priority = 0);
  /// Stops the nodes and waits for them.
  ~NodeThread();
  NodeThread(const NodeThread&) = delete;
  NodeThread& operator=(const NodeThread&) = delete;

  /// Waits until all of its nodes have stopped.
  void join();

 private:
  std::vector<Node*> nodes_;
  std::thread thread_;
};

}  // namespace tandem::runtime
