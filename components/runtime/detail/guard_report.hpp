// SPDX-License-Identifier: Apache-2.0
// Reports the datagrams that WireGuard drops, on /diagnostics and in the log. Private to runtime/.
#pragma once

#include <memory>

#include <msgs.hpp>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/guarded_transport.hpp"
#include "tandem/runtime/detail/wire_guard.hpp"

namespace tandem::runtime {

class DdsNode;
class Writer;

/// Reports new drops at most once a minute, from one node per process. Opens /diagnostics at the
/// first drop and publishes its status every second from then on, like a node's other diagnostics.
class GuardReport {
 public:
  static constexpr double kEvery = 60.0;  ///< [s] between two reports

  explicit GuardReport(DdsNode& node);
  ~GuardReport();
  GuardReport(const GuardReport&) = delete;
  GuardReport& operator=(const GuardReport&) = delete;

  /// Reports and publishes what is due; returns when to poll next [s], steady clock.
  double poll(double now);

 private:
  void report(WireGuard::Reported& reported);
  void publish();

  DdsNode& node_;
  WireGuard& guard_ = process_guard();
  std::shared_ptr<Codec> codec_;
  std::shared_ptr<Writer> writer_;
  diagnostic_msgs::msg::DiagnosticStatus status_;
  bool refused_ = false;  // DDS refused to open /diagnostics
};

}  // namespace tandem::runtime
