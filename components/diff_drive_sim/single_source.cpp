// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/single_source.hpp"

#include <algorithm>

namespace tandem {
namespace {

// Bounds the memory; further writers would not change the result.
constexpr std::size_t kMaxWriters = 16;

}  // namespace

bool SingleSource::same_source(const Sender& a, const Sender& b) {
  constexpr int kProcessBytes = 8, kSubjectBytes = 6;
  if (a.writer == b.writer) return true;
  const bool secured = (a.writer[0] & 0x80) != 0;
  return a.type != b.type &&
         std::equal(a.writer.begin(), a.writer.begin() + (secured ? kSubjectBytes : kProcessBytes),
                    b.writer.begin());
}

bool SingleSource::on_command(const Writer& writer, Type type, double t) {
  const Sender now{writer, type};
  // Entries in the future, which are not fresh either, are from before the clock was set back.
  std::erase_if(heard_, [&](const auto& before) {
    return before.value.writer == writer || !before.fresh(t, timeout_);
  });
  const bool alone = std::all_of(heard_.begin(), heard_.end(),
                                 [&](const auto& other) { return same_source(now, other.value); });
  if (heard_.size() < kMaxWriters) heard_.push_back({now, t});
  return alone;
}

}  // namespace tandem
