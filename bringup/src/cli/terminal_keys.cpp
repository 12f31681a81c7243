// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/terminal_keys.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace tandem {
namespace {

const std::map<char, TerminalKeys::Stick> kMoves{{'i', {1, 0}},  {'o', {1, -1}}, {'j', {0, 1}},
                                                 {'l', {0, -1}}, {'u', {1, 1}},  {',', {-1, 0}},
                                                 {'.', {-1, 1}}, {'m', {-1, -1}}};
const std::map<char, TerminalKeys::Stick> kScales{{'q', {1.1, 1.1}}, {'z', {0.9, 0.9}},
                                                  {'w', {1.1, 1}},   {'x', {0.9, 1}},
                                                  {'e', {1, 1.1}},   {'c', {1, 0.9}}};

// Replaces the arrow keys, ESC [ A … D or ESC O A … D, by i , l j and drops other ESC
// characters.
std::string without_escapes(std::string_view characters) {
  constexpr std::string_view kArrows = "i,lj";
  std::string keys;
  for (std::size_t i = 0; i < characters.size(); ++i) {
    if (characters[i] != '\x1b') {
      keys.push_back(characters[i]);
    } else if (i + 2 < characters.size() && characters[i + 2] >= 'A' && characters[i + 2] <= 'D') {
      keys.push_back(kArrows[static_cast<std::size_t>(characters[i + 2] - 'A')]);
      i += 2;
    }
  }
  return keys;
}

double scaled(double scale, double factor) { return std::clamp(scale * factor, 0.05, 1.0); }

}  // namespace

TerminalKeys::Order TerminalKeys::type(std::string_view characters, double now) {
  Order order = Order::kNone;
  const std::string keys = without_escapes(characters);
  watch_backlog(keys, now);
  for (const char key : keys) {
    if (key == ' ') order = Order::kEmergencyStop;
    if (key == 'r') order = Order::kRelease;
    press(key, now);
  }
  return order;
}

void TerminalKeys::watch_backlog(const std::string& keys, double now) {
  const double usual = kAtOnce + kFastest * (now - std::exchange(read_, now));
  const auto moves = static_cast<double>(
      std::count_if(keys.begin(), keys.end(), [](char key) { return kMoves.contains(key); }));
  if (moves > usual || (moves > 0.0 && now <= ignored_)) ignored_ = now + kRepeat;
}

void TerminalKeys::press(char key, double now) {
  if (const auto scale = kScales.find(key); scale != kScales.end()) {
    linear_ = scaled(linear_, scale->second.linear);
    angular_ = scaled(angular_, scale->second.angular);
  } else if (kMoves.contains(key) && now > ignored_) {
    const bool repeats = key == key_ && now <= until_;
    until_ = repeats ? std::max(until_, now + kRepeat) : now + kFirst;
    key_ = key;
  } else {
    key_ = 0;  // any other key stops
  }
}

std::optional<TerminalKeys::Stick> TerminalKeys::held(double now) const {
  if (key_ == 0 || now > until_) return std::nullopt;
  const Stick& move = kMoves.at(key_);
  return Stick{move.linear * linear_, move.angular * angular_};
}

}  // namespace tandem
