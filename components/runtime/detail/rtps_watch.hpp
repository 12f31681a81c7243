// SPDX-License-Identifier: Apache-2.0
// Removes submessages that would make Fast DDS allocate without bound, based on the earlier traffic
// of this process. Private to runtime/.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <unordered_map>
#include <vector>

#include "tandem/runtime/detail/rtps_guard.hpp"
#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem::runtime {

using GuidPrefix = std::array<std::uint8_t, 12>;

struct GuidPrefixHash {
  std::uint64_t seed = 0;
  std::size_t operator()(const GuidPrefix& prefix) const;
};

/// Limits a rate: tokens refill at `per_second` [1/s] up to `burst`.
class TokenBucket {
 public:
  TokenBucket(double burst, double per_second) : burst_{burst}, rate_{per_second}, left_{burst} {}
  /// Takes tokens at time `now` [s]; returns false and takes none if too few are left.
  [[nodiscard]] bool take(double tokens, double now);

 private:
  double burst_, rate_, left_, last_ = 0.0;
};

/// Tracks the progress of each reliable reader of this process with each writer: its last ACKNACK
/// and what has arrived in order since. Fast DDS 2.9.1 keeps a list entry for every sequence number
/// farther ahead, and a GAP may name 2⁶³ of them.
class ReaderProgress {
 public:
  static constexpr std::int64_t kWindow = 2048;  ///< numbers accepted ahead of the first missing
  static constexpr std::int64_t kWide = 256;     ///< maximum width of a GAP that passes unchanged
  static constexpr std::int64_t kLeap = 32;      ///< maximum number of samples lost at once
  static constexpr std::int64_t kCounts = 4096;  ///< maximum increase of a HEARTBEAT's count

  /// Records the acknowledgements in a datagram sent by this process.
  void sent(std::span<const std::uint8_t> datagram);
  /// Narrows wide GAPs or replaces them by an equivalent HEARTBEAT, and removes submessages beyond
  /// the window, which a reliable writer repeats. Returns the number of removed submessages.
  [[nodiscard]] int narrow(std::span<std::uint8_t> datagram);

 private:
  struct Progress {
    std::uint32_t reader;
    std::int64_t next;  // the first missing number
  };
  struct Source {
    /// The lowest first missing number of the readers that `reader` addresses; 0 if unknown.
    [[nodiscard]] std::int64_t least(std::uint32_t reader) const;
    /// Records that [from, to) has arrived or will never arrive.
    void advance(std::uint32_t reader, std::int64_t from, std::int64_t to);
    void acknowledge(std::uint32_t reader, std::int64_t base);

    /// Whether the writer's claim to hold nothing before `first` is plausible given the numbers
    /// seen so far. An implausible claim is accepted once a later message, by `order`, repeats it
    /// with a similar number.
    [[nodiscard]] bool believes(std::int64_t first, bool usual_count, std::int64_t order);

    std::vector<Progress> readers;
    std::int64_t top = 0;      // largest number seen from this writer
    std::int64_t claimed = 0;  // `first` of the last rejected claim; 0: none
    std::int64_t claimed_order = 0;
    std::int64_t gaps = 0;         // number of GAPs seen
    std::uint32_t heartbeats = 0;  // count of the last HEARTBEAT; 0: none yet
  };
  using Key = std::array<std::uint8_t, 16>;  // a writer's GUID
  struct KeyHash {
    std::size_t operator()(const Key& key) const;
  };

  [[nodiscard]] Source* find(const GuidPrefix& prefix, const std::uint8_t* entity);
  [[nodiscard]] Source& of(const GuidPrefix& prefix, const std::uint8_t* entity);
  [[nodiscard]] static bool in_window(std::int64_t number, std::int64_t least);
  [[nodiscard]] static bool passes_data(const rtps_message::Submessage& data, Source& source);
  [[nodiscard]] static bool passes_heartbeat(const rtps_message::Submessage& heartbeat,
                                             Source* source);
  [[nodiscard]] static bool passes_gap(const rtps_message::Submessage& gap, std::uint8_t* body,
                                       Source* source);

  std::unordered_map<Key, Source, KeyHash> writers_;
};

/// Limits announced participants and endpoints, because Fast DDS keeps them until the lease ends.
class Announcements {
 public:
  static constexpr double kLongestLease = 100.0;  ///< [s]; longer leases are shortened to this
  static constexpr double kSecondSight = 0.05;    ///< [s]; a repetition comes later than this

  Announcements();
  /// Removes announcements above the rate limit and shortens leases. `now`: [s]. Returns the number
  /// of removed submessages.
  [[nodiscard]] int thin(std::span<std::uint8_t> datagram, double now);

 private:
  struct Known {
    double until;          // end of the lease [s]
    std::int64_t last[2];  // last sequence numbers of publications, subscriptions
    int endpoints;
  };
  struct Seen {
    std::uint32_t mark = 0;
    double at = 0.0;  // [s]
  };

  [[nodiscard]] bool admits_participant(const GuidPrefix& prefix, double lease, double now);
  [[nodiscard]] bool admits_endpoint(const GuidPrefix& prefix, int kind, std::int64_t number,
                                     std::size_t size, double now);
  void forget(double now);

  GuidPrefixHash hash_;
  std::unordered_map<GuidPrefix, Known, GuidPrefixHash> known_;
  std::vector<Seen> seen_;
  double next_look_ = 0.0;
  TokenBucket first_sight_{64, 10}, second_sight_{64, 5}, endpoints_{2048, 100};
};

}  // namespace tandem::runtime
