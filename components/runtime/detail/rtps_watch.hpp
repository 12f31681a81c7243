// SPDX-License-Identifier: Apache-2.0
// Removes from checked datagrams what would make Fast DDS allocate without bound, using what this
// process sends and has received. Private to runtime/.
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

/// Tokens that come back with time.
class TokenBucket {
 public:
  TokenBucket(double burst, double per_second) : burst_{burst}, rate_{per_second}, left_{burst} {}
  /// `now`: [s]. False, and nothing is taken, if there are not so many.
  [[nodiscard]] bool take(double tokens, double now);

 private:
  double burst_, rate_, left_, last_ = 0.0;
};

/// How far each reliable reader of this process has got with each writer: what its last ACKNACK
/// said, and what has arrived in order since. Of numbers that lie farther ahead Fast DDS 2.9.1
/// keeps a list, one entry each, and a GAP may name 2⁶³ of them.
class ReaderProgress {
 public:
  static constexpr std::int64_t kWindow = 2048;  ///< ahead of the first missing sample
  static constexpr std::int64_t kWide = 256;     ///< of a GAP that is passed on as it is
  static constexpr std::int64_t kLeap = 32;      ///< of samples that may be lost at once
  static constexpr std::int64_t kCounts = 4096;  ///< by which a HEARTBEAT's count may grow

  /// Reads what readers of this process acknowledge.
  void sent(std::span<const std::uint8_t> datagram);
  /// Makes wide GAPs narrow or a HEARTBEAT that says the same, and takes out what lies beyond the
  /// window: a reliable writer sends it again. The number of submessages taken out.
  [[nodiscard]] int narrow(std::span<std::uint8_t> datagram);

 private:
  struct Progress {
    std::uint32_t reader;
    std::int64_t next;  // the first that is missing
  };
  struct Source {
    /// The first that one of the readers which `reader` names misses; 0: not known.
    [[nodiscard]] std::int64_t least(std::uint32_t reader) const;
    /// `from` to `to` are there, or will never be.
    void advance(std::uint32_t reader, std::int64_t from, std::int64_t to);
    void acknowledge(std::uint32_t reader, std::int64_t base);

    /// Whether a writer that has got as far as was seen may have nothing before `first`; else true
    /// once it has said about the same just before, in what came earlier by its `order`.
    [[nodiscard]] bool believes(std::int64_t first, bool usual_count, std::int64_t order);

    std::vector<Progress> readers;
    std::int64_t top = 0;      // largest number that was seen of it
    std::int64_t claimed = 0;  // the last that was not believed
    std::int64_t claimed_order = 0;
    std::int64_t gaps = 0;         // that were seen
    std::uint32_t heartbeats = 0;  // the last one's count; 0: none yet
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

/// Who was announced, and how much of it: Fast DDS keeps all until their leases end.
class Announcements {
 public:
  static constexpr double kLongestLease = 100.0;  ///< [s]; longer ones are made this long
  static constexpr double kSecondSight = 0.05;  ///< [s] after which an announcement is a repetition

  Announcements();
  /// Takes out announcements that are too many, and shortens leases. `now`: [s]. The number of
  /// submessages taken out.
  [[nodiscard]] int thin(std::span<std::uint8_t> datagram, double now);

 private:
  struct Known {
    double until;          // [s] its lease ends
    std::int64_t last[2];  // number of its last publication and subscription
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
