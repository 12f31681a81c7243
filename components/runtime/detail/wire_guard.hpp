// SPDX-License-Identifier: Apache-2.0
// Checks the datagrams received by all participants of the process. Private to runtime/.
#pragma once

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "tandem/runtime/detail/announcements.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem::runtime {

/// Number of dropped datagrams of one kind from one source.
struct DropCount {
  Drop drop;
  std::string source;  ///< "192.168.1.7"; "others" beyond kMaxSources
  std::uint64_t count;
};

/// Checks each datagram before Fast DDS parses it and counts the dropped ones. `source`: the IPv4
/// address, or the last 4 bytes of an IPv6 address, in network order. Thread-safe.
class WireGuard {
 public:
  static constexpr std::size_t kMaxSources = 64;  ///< sources counted separately

  explicit WireGuard(const GuardLimits& limits) : limits_{limits} {}

  /// Sets GuardLimits::all_protected: whether the domain's governance protects every datagram.
  void expect_protection(bool of_all) { all_protected_ = of_all; }

  /// Whether the datagram is valid and allowed in this domain; counts it.
  [[nodiscard]] bool admits(std::span<const std::uint8_t> datagram, std::uint32_t source);
  /// Why the datagram is not admitted.
  [[nodiscard]] Drop fault_of(std::span<const std::uint8_t> datagram) const;
  /// Whether DDS Security authenticates the datagram as a whole, which any change would invalidate.
  [[nodiscard]] bool must_not_change(std::span<const std::uint8_t> datagram) const;
  /// Removes announcements beyond what the process keeps, and counts them. `now`: [s], steady
  /// clock.
  void thin(std::span<std::uint8_t> datagram, std::uint32_t source, double now);
  /// Counts drops.
  void count(Drop drop, std::uint32_t source, int times = 1);

  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  /// All drops since the start, most frequent first.
  [[nodiscard]] std::vector<DropCount> drops() const;

  /// What has been reported so far.
  struct Reported {
    std::vector<DropCount> drops;
    std::uint64_t count = 0;
    double next = 0.0;  ///< earliest time of the next report [s], steady clock
  };
  /// Selects the one node of the process that reports. The first caller gets the report state until
  /// it calls release_report(); other callers get null.
  [[nodiscard]] Reported* claim_report(const void* who);
  void release_report(const void* who);

 private:
  const GuardLimits limits_;
  std::atomic<bool> all_protected_ = false;
  std::atomic<std::uint64_t> received_ = 0, dropped_ = 0;
  std::atomic<const void*> reporter_ = nullptr;
  Reported reported_;  // used by the reporter only
  std::mutex announcements_mutex_;
  Announcements announcements_;
  mutable std::mutex mutex_;  // guards the members below
  std::map<std::uint32_t, std::array<std::uint64_t, kDropKinds>> by_source_;
  std::array<std::uint64_t, kDropKinds> by_others_{};
};

/// Formats drops as "12 fragment from 192.168.1.7, 3 header from 127.0.0.1".
[[nodiscard]] std::string summary(const std::vector<DropCount>& drops);

}  // namespace tandem::runtime
