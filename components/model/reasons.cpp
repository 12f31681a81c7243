// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/reasons.hpp"

#include <array>

namespace tandem {
namespace {

constexpr std::string_view kAny = "…";

// With their lengths, because nodes look a reason up each time they publish.
constexpr auto kTexts = [] {
  std::array<std::string_view, kReasons.size()> all;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = kReasons[i].text;
  return all;
}();

// Whether `written` starts with `text` and then ends or continues with details.
bool begins(std::string_view written, std::string_view text) {
  if (!written.starts_with(text)) return false;
  const std::string_view rest = written.substr(text.size());
  return rest.empty() || rest.starts_with(": ") || rest.starts_with(" (");
}

bool fits(std::string_view written, std::string_view text) {
  const bool open_before = text.starts_with(kAny), open_after = text.ends_with(kAny);
  if (open_before) text.remove_prefix(kAny.size());
  if (open_after) text.remove_suffix(kAny.size());
  if (open_before && open_after) return written.find(text) != std::string_view::npos;
  if (open_before) return written.ends_with(text);
  return open_after ? written.starts_with(text) : begins(written, text);
}

// The longest reason that fits; kOther if none does.
Reason find(std::string_view written) {
  auto best = static_cast<std::size_t>(Reason::kOther);
  for (std::size_t i = 0; i < kTexts.size(); ++i)
    if (kTexts[i].size() > kTexts[best].size() && fits(written, kTexts[i])) best = i;
  return static_cast<Reason>(best);
}

}  // namespace

Reason reason_in(std::string_view written) {
  if (written.empty()) return Reason::kNone;
  while (true) {
    if (const Reason reason = find(written); reason != Reason::kOther) return reason;
    const auto colon = written.find(": ");
    if (colon == std::string_view::npos) return Reason::kOther;
    written.remove_prefix(colon + 2);
  }
}

}  // namespace tandem
