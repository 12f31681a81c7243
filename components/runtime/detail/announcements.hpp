// SPDX-License-Identifier: Apache-2.0
// Bounds what announced participants and endpoints make Fast DDS keep. Private to runtime/.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <unordered_map>

#include "tandem/runtime/detail/rtps_edit.hpp"

namespace tandem::runtime {

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
    std::uint32_t mark;
    double at;  // [s]
  };
  struct Freed {
    void operator()(void* block) const { std::free(block); }
  };

  [[nodiscard]] bool admits_participant(const GuidPrefix& prefix, double lease, double now);
  [[nodiscard]] bool admits_endpoint(const GuidPrefix& prefix, int kind, std::int64_t number,
                                     std::size_t size, double now);
  void forget(double now);

  GuidPrefixHash hash_;
  std::unordered_map<GuidPrefix, Known, GuidPrefixHash> known_;
  std::unique_ptr<Seen[], Freed> seen_;
  double next_look_ = 0.0;
  // A fleet starts at once, hence the bursts. Each admitted participant costs Fast DDS 0.2 ms a
  // second until its lease ends, and a message to every other one at first, hence the low rates.
  TokenBucket first_sight_{128, 5}, second_sight_{32, 5}, endpoints_{8192, 400};
};

}  // namespace tandem::runtime
