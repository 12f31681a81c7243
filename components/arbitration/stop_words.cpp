// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/stop_words.hpp"

#include <algorithm>

namespace tandem {
namespace {

constexpr std::uint64_t kWindow = 64;         // samples before the newest that are distinguished
constexpr std::size_t kMaxRemembered = 1000;  // senders

}  // namespace

bool StopWords::Word::mark(std::uint64_t sequence) {
  if (sequence > newest) {
    const std::uint64_t ahead = sequence - newest;
    received = (ahead < kWindow ? received << ahead : 0) | 1;
    newest = sequence;
    return true;
  }
  const std::uint64_t behind = newest - sequence;
  if (behind >= kWindow) return false;
  const std::uint64_t bit = std::uint64_t{1} << behind;
  if ((received & bit) != 0) return false;
  received |= bit;
  return true;
}

bool StopWords::on_word(const Sender& sender, std::uint64_t sequence, bool pressed) {
  if (words_.size() >= kMaxRemembered) forget_departed();
  Word& word = words_[sender];
  if (!word.mark(sequence)) return false;
  if (sequence < word.newest) return true;
  word.pressed = pressed;
  if (!pressed) drop_presses_of_departed();
  return true;
}

void StopWords::set_present(Word& word, bool present) {
  if (present && !word.present) word.newest = word.received = 0;
  word.present = present;
}

void StopWords::drop_presses_of_departed() {
  for (auto& [sender, word] : words_) word.pressed = word.pressed && word.present;
}

// Removes senders that have left and whose last message was `false`.
void StopWords::forget_departed() {
  std::erase_if(words_,
                [](const auto& entry) { return !entry.second.present && !entry.second.pressed; });
}

bool StopWords::pressed() const {
  return std::any_of(words_.begin(), words_.end(),
                     [](const auto& entry) { return entry.second.pressed; });
}

}  // namespace tandem
