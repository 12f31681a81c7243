// SPDX-License-Identifier: Apache-2.0
// Publishes a node's log lines on /rosout for rqt_console. Private to runtime/.
#pragma once

#include <memory>

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

/// Publishes the node's log lines on /rosout, from the logging thread. If DDS rejects a line, it
/// appears on stderr only; logging the failure would recurse.
class RosOut {
 public:
  explicit RosOut(NodeCore& node);
  ~RosOut();
  RosOut(const RosOut&) = delete;
  RosOut& operator=(const RosOut&) = delete;

 private:
  NodeCore& node_;
  std::shared_ptr<PublisherPort> lines_;
};

/// The level as in rcl_interfaces/msg/Log and LoggerLevel; kOff maps to FATAL.
[[nodiscard]] std::uint8_t severity(LogLevel level);

}  // namespace tandem::runtime
