// SPDX-License-Identifier: Apache-2.0
// Filters the datagrams of all transports of the process. Private to runtime/.
#pragma once

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "tandem/runtime/detail/rtps_guard.hpp"
#include "tandem/runtime/detail/rtps_watch.hpp"

namespace tandem::runtime {

/// Datagrams of one kind and source that were dropped.
struct DropCount {
  Drop drop;
  std::string source;  ///< "192.168.1.7"; "others" beyond a number of sources
  std::uint64_t count;
};

/// Checks each datagram before Fast DDS parses it and counts the dropped ones. Thread-safe.
class WireGuard {
 public:
  static constexpr std::size_t kMostSources = 64;  ///< that are counted apart

  explicit WireGuard(const GuardLimits& limits) : limits_{limits} {}

  /// Whether the domain's governance protects every datagram: GuardLimits::all_protected.
  void expect_protection(bool of_all) { all_protected_ = of_all; }
  /// The guard of this process, with the limits of its environment.
  static WireGuard& shared();

  /// Whether Fast DDS may have the datagram. Takes out of it what would make Fast DDS keep too
  /// much. `source`: its IPv4 address, or the end of an IPv6 one, in network order.
  [[nodiscard]] bool admits(std::span<std::uint8_t> datagram, std::uint32_t source);
  /// What this process sends.
  void sent(std::span<const std::uint8_t> datagram);

  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  /// All since the start, most frequent first.
  [[nodiscard]] std::vector<DropCount> drops() const;

  /// What has been reported so far.
  struct Reported {
    std::vector<DropCount> drops;
    std::uint64_t count = 0;
    double next = 0.0;  ///< [s, steady] not before
  };
  /// One node of the process reports: the first caller gets what has been reported, until it
  /// releases it; other callers get null.
  [[nodiscard]] Reported* claim_report(const void* who);
  void release_report(const void* who);

 private:
  void count(Drop drop, std::uint32_t source, int times = 1);

  const GuardLimits limits_;
  std::atomic<bool> all_protected_ = false;
  std::atomic<std::uint64_t> received_ = 0, dropped_ = 0;
  std::atomic<const void*> reporter_ = nullptr;
  Reported reported_;       // the reporter's
  std::mutex watch_mutex_;  // guards these two
  ReaderProgress progress_;
  Announcements announcements_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<std::uint32_t, std::array<std::uint64_t, kDropKinds>> by_source_;
  std::array<std::uint64_t, kDropKinds> by_others_{};
};

/// "12 fragment from 192.168.1.7, 3 header from 127.0.0.1".
[[nodiscard]] std::string summary(const std::vector<DropCount>& drops);

}  // namespace tandem::runtime
