// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class WorkerPort;

/// Does work that would take too long between a node's callbacks: on a thread of its own over DDS,
/// and within the same instant of simulated time on a LocalBus. What the work and the node's
/// callbacks share needs a mutex.
class TANDEM_EXPORT Worker {
 public:
  /// Does the pending work. Returns after how long [s] to call it again without wake() (0: at
  /// once); nullopt: not before wake().
  using Work = std::function<std::optional<double>()>;
  /// Called on the node's thread after the work, once for all work that has ended since; may be
  /// empty.
  using Done = std::function<void()>;

  Worker() = default;
  /// Made by Node::create_worker().
  explicit Worker(std::shared_ptr<WorkerPort> port);
  /// Waits for work that is running.
  ~Worker();
  Worker(Worker&&) noexcept = default;
  Worker& operator=(Worker&& other) noexcept;

  /// Has the work done soon, once for all calls since it last began.
  void wake() const;

 private:
  void close();

  std::shared_ptr<WorkerPort> port_;
};

}  // namespace tandem::runtime
