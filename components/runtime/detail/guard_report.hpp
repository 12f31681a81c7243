// SPDX-License-Identifier: Apache-2.0
// Reports the datagrams that WireGuard drops, on /diagnostics and in the log. Private to runtime/.
#pragma once

#include <memory>

#include <msgs.hpp>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/wire_guard.hpp"

namespace tandem::runtime {

class NodeCore;

/// Tells once a minute at most what was dropped since; one node of a process does. Opens
/// /diagnostics with the first drop, and from then on says every second how things stand, as other
/// parts of a node do there.
class GuardReport {
 public:
  static constexpr double kEvery = 60.0;  ///< [s] between two reports

  explicit GuardReport(NodeCore& node);
  ~GuardReport();
  GuardReport(const GuardReport&) = delete;
  GuardReport& operator=(const GuardReport&) = delete;

  /// Does what is due and returns when to poll next [s, steady].
  double poll(double now);

 private:
  void report(WireGuard::Reported& reported);
  void publish();

  NodeCore& node_;
  WireGuard& guard_ = WireGuard::shared();
  std::shared_ptr<Codec> codec_;
  std::shared_ptr<Writer> writer_;
  diagnostic_msgs::msg::DiagnosticStatus status_;
  bool refused_ = false;  // /diagnostics, by DDS
};

}  // namespace tandem::runtime
