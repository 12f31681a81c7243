// SPDX-License-Identifier: Apache-2.0
// Removes sequence numbers that a writer cannot have reached, and bounds how far a message moves a
// reader, based on the earlier traffic of a participant. Private to runtime/.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "tandem/runtime/detail/rtps_edit.hpp"

namespace tandem::runtime {

/// How far a writer has come, judged by what its messages claim.
class WriterReach {
 public:
  static constexpr std::int64_t kLeap = 32;      ///< `leap` of most writers
  static constexpr std::int64_t kWindow = 2048;  ///< claims this close to each other agree
  static constexpr int kClaims = 3;              ///< agreeing claims that prove a leap, over at
  static constexpr double kProofTime = 0.1;      ///< least this time [s]
  static constexpr double kFastest = 1e5;        ///< [1/s]; no writer counts faster than this
  static constexpr std::int64_t kEnd = std::int64_t{1} << 40;  ///< no writer reaches this number

  /// `leap`: numbers skipped at once that need no proof.
  explicit WriterReach(std::int64_t leap = kLeap) : leap_{leap} {}
  /// Whether the writer can have reached `number` at time `now` [s]. The first claim is believed,
  /// as are small steps. A leap is believed if the time since the last progress suffices for it
  /// and it is claimed repeatedly without a message in between that contradicts it.
  [[nodiscard]] bool believes(std::int64_t number, double now);
  /// Records progress that is certain.
  void know(std::int64_t number, double now);
  /// The largest number believed so far; -1: none.
  [[nodiscard]] std::int64_t top() const { return top_; }
  [[nodiscard]] std::int64_t leap() const { return leap_; }

 private:
  std::int64_t leap_;
  std::int64_t top_ = -1;
  double risen_ = 0.0;        // when top_ last rose [s]
  std::int64_t claimed_ = 0;  // the claim that is being proved
  int claims_ = 0;            // how often it was made
  double first_claim_ = 0.0;  // [s]
};

using ReaderProgressKey = std::array<std::uint8_t, 16>;  ///< a writer's GUID

/// Tracks the progress of each reliable reader of one participant with each writer: its last
/// ACKNACK and what has arrived in order since. Fast DDS 2.9.1 keeps a list entry for each sequence
/// number that is farther ahead, and counts through those that a HEARTBEAT or GAP skips while it
/// holds the reader's lock; either may skip 2⁶³. A discovery server passes on to each participant
/// only the announcements that it needs, so its numbers leap farther than those of other writers.
/// Times are of a steady clock [s]. Not thread-safe.
class ReaderProgress {
 public:
  static constexpr std::int64_t kWindow = 2048;  ///< numbers accepted ahead of the first missing
  /// The same for what a discovery server announces, also in one leap: some hundred endpoints of
  /// each robot. A list of as many entries takes about 3 MB.
  static constexpr std::int64_t kServerWindow = std::int64_t{1} << 16;
  static constexpr std::int64_t kWide = 256;  ///< maximum width of a GAP that passes unchanged
  /// Numbers that one HEARTBEAT may skip; counting through them takes Fast DDS about 10 ms.
  static constexpr std::int64_t kStep = std::int64_t{1} << 22;

  /// Records the acknowledgements in a datagram sent by the participant.
  void sent(std::span<const std::uint8_t> datagram, double now);
  /// Narrows wide GAPs or replaces them by an equivalent HEARTBEAT, shortens leaps, renumbers
  /// HEARTBEATs, and removes submessages beyond the window, which a reliable writer repeats.
  /// Returns the number of removed submessages, without the samples that arrive while a reader is
  /// taken to a writer that is far ahead.
  [[nodiscard]] int narrow(std::span<std::uint8_t> datagram, double now);
  /// A number above all that readers of the participant can have received from that writer, at most
  /// kStep above what they have acknowledged.
  [[nodiscard]] std::int64_t beyond(const GuidPrefix& prefix, std::uint32_t writer) const;
  /// Forgets the writers of a participant, which has been started again.
  void forget(const GuidPrefix& prefix);

 private:
  struct Progress {
    std::uint32_t reader;
    std::int64_t next;  // the first missing number
  };
  struct Source {
    Source(std::int64_t leap, std::int64_t farthest) : reach{leap}, window{farthest} {}
    /// The lowest first missing number of the readers that `reader` addresses; 0 if unknown.
    [[nodiscard]] std::int64_t least(std::uint32_t reader) const;
    /// Records that [from, to) has arrived or will never arrive.
    void advance(std::uint32_t reader, std::int64_t from, std::int64_t to);
    void acknowledge(std::uint32_t reader, std::int64_t base);
    /// The count to put into a HEARTBEAT that the writer numbered `count`.
    [[nodiscard]] std::uint32_t renumbered(std::uint32_t count);

    std::vector<Progress> readers;
    WriterReach reach;
    std::int64_t window;         // numbers accepted ahead of the first missing
    std::uint32_t count = 0;     // of the writer's last HEARTBEAT
    std::uint32_t passed = 0;    // count of the last HEARTBEAT that was passed on; 0: none
    std::uint32_t messages = 0;  // believed ones; the least used source is forgotten first
    bool catching_up = false;    // whether the last HEARTBEAT was shortened to kStep
    bool acknowledged = false;   // whether a reader has answered it
  };
  struct KeyHash {
    std::size_t operator()(const ReaderProgressKey& key) const;
  };

  [[nodiscard]] Source& of(const GuidPrefix& prefix, const std::uint8_t* entity);
  void forget_one();
  [[nodiscard]] static bool passes_data(const rtps_message::Submessage& data, std::uint8_t* body,
                                        Source& source, double now);
  [[nodiscard]] static bool passes_heartbeat(const rtps_message::Submessage& heartbeat,
                                             std::uint8_t* body, Source& source, double now);
  [[nodiscard]] static bool passes_gap(const rtps_message::Submessage& gap, std::uint8_t* body,
                                       Source& source, double now);

  std::unordered_map<ReaderProgressKey, Source, KeyHash> writers_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace tandem::runtime
