// SPDX-License-Identifier: Apache-2.0
// What the senders of the emergency stop say, together.
#pragma once

#include <array>
#include <cstdint>
#include <map>

namespace tandem {

/// The last word of each sender of the emergency stop. While one that is present says `true`, the
/// `false` of another takes nothing back. The `true` of a sender that has left stays until any
/// sender says `false`.
///
/// A sample may be heard several times, and after younger ones of its sender: several readers hear
/// each sender. Samples of one sender are therefore ordered by their sequence number.
class StopWords {
 public:
  using Sender = std::array<std::uint8_t, 16>;

  /// Whether this sample is new, that is not a repetition. One that is older than the sender's last
  /// does not change their word.
  bool on_word(const Sender& sender, std::uint64_t sequence, bool pressed);
  /// `is_present(sender)` is asked for every sender that has been heard. A sender that returns
  /// after it had left counts by what it sends then, even if that was heard before.
  template <class IsPresent>
  void update_presence(IsPresent is_present) {
    for (auto& [sender, word] : words_) set_present(word, is_present(sender));
  }

  /// Whether somebody's word is `true`.
  [[nodiscard]] bool pressed() const;

 private:
  struct Word {
    std::uint64_t newest = 0;  // sequence number of the last word; 0: none
    std::uint64_t heard = 0;   // bit i: whether newest − i was heard
    bool pressed = false;
    bool present = true;

    // Whether that sample was not heard before; marks it as heard.
    bool mark(std::uint64_t sequence);
  };

  static void set_present(Word& word, bool present);
  void drop_presses_of_departed();
  void forget_departed();

  std::map<Sender, Word> words_;
};

}  // namespace tandem
