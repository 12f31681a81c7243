// SPDX-License-Identifier: Apache-2.0
// Combines the emergency stop messages of all senders.
#pragma once

#include <array>
#include <cstdint>
#include <map>

namespace tandem {

/// The last message of each emergency stop sender. While a present sender's last message is `true`,
/// `false` from another sender does not cancel it. A `true` from a sender that has left stays until
/// any sender sends `false`.
///
/// A sample may be received several times, and after newer ones of its sender, because several
/// readers receive from each sender. Samples of one sender are therefore ordered by sequence
/// number.
class StopWords {
 public:
  using Sender = std::array<std::uint8_t, 16>;

  /// Returns whether this sample is new rather than a repetition. A sample older than the sender's
  /// newest does not change the sender's state.
  bool on_word(const Sender& sender, std::uint64_t sequence, bool pressed);
  /// Calls `is_present(sender)` for every known sender. For a sender that has left and returned,
  /// all its samples count as new, even those received before.
  template <class IsPresent>
  void update_presence(IsPresent is_present) {
    for (auto& [sender, word] : words_) set_present(word, is_present(sender));
  }

  /// Whether the last message of any sender is `true`.
  [[nodiscard]] bool pressed() const;

 private:
  struct Word {
    std::uint64_t newest = 0;    // highest sequence number received; 0: none
    std::uint64_t received = 0;  // bit i: whether sample newest − i was received
    bool pressed = false;
    bool present = true;

    // Marks the sample as received; returns whether it is new.
    bool mark(std::uint64_t sequence);
  };

  static void set_present(Word& word, bool present);
  void drop_presses_of_departed();
  void forget_departed();

  std::map<Sender, Word> words_;
};

}  // namespace tandem
