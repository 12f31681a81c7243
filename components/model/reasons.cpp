// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/reasons.hpp"

namespace tandem {
namespace {

constexpr std::string_view kAny = "…";

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

const ReasonText* find(std::string_view written) {
  const ReasonText* best = nullptr;
  for (const ReasonText& reason : kReasons)
    if (fits(written, reason.text) &&
        (!best || std::string_view{reason.text}.size() > std::string_view{best->text}.size()))
      best = &reason;
  return best;
}

}  // namespace

std::string remedy_for(std::string_view written) {
  while (true) {
    if (const ReasonText* reason = find(written)) return reason->remedy;
    const auto colon = written.find(": ");
    if (colon == std::string_view::npos) return {};
    written.remove_prefix(colon + 2);
  }
}

}  // namespace tandem
