// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/wire_guard.hpp"

#include <algorithm>
#include <cstring>

#include <spdlog/fmt/fmt.h>

namespace tandem::runtime {
namespace {

std::string dotted(std::uint32_t address) {
  std::array<std::uint8_t, 4> part{};
  std::memcpy(part.data(), &address, part.size());
  return fmt::format("{}.{}.{}.{}", part[0], part[1], part[2], part[3]);
}

void add(const std::array<std::uint64_t, kDropKinds>& counts, const std::string& source,
         std::vector<DropCount>& drops) {
  for (std::size_t kind = 0; kind < kDropKinds; ++kind)
    if (counts[kind] > 0) drops.push_back({static_cast<Drop>(kind), source, counts[kind]});
}

}  // namespace

Drop WireGuard::fault_of(std::span<const std::uint8_t> datagram) const {
  GuardLimits limits = limits_;
  limits.all_protected = all_protected_;
  return check_datagram(datagram, limits);
}

bool WireGuard::admits(std::span<const std::uint8_t> datagram, std::uint32_t source) {
  ++received_;
  const Drop drop = fault_of(datagram);
  if (drop == Drop::kNone) return true;
  if (drop != Drop::kGoodbye) count(drop, source);  // genuine goodbyes are not attacks
  return false;
}

bool WireGuard::must_not_change(std::span<const std::uint8_t> datagram) const {
  return all_protected_ && is_protected(datagram);
}

void WireGuard::thin(std::span<std::uint8_t> datagram, std::uint32_t source, double now) {
  int many = 0;
  {
    const std::lock_guard lock{announcements_mutex_};
    many = announcements_.thin(datagram, now);
  }
  count(Drop::kAnnouncement, source, many);
}

WireGuard::Reported* WireGuard::claim_report(const void* who) {
  const void* nobody = nullptr;
  const bool its_own = reporter_.compare_exchange_strong(nobody, who) || nobody == who;
  return its_own ? &reported_ : nullptr;
}

void WireGuard::release_report(const void* who) { reporter_.compare_exchange_strong(who, nullptr); }

void WireGuard::count(Drop drop, std::uint32_t source, int times) {
  if (times == 0) return;
  dropped_ += static_cast<std::uint64_t>(times);
  const std::lock_guard lock{mutex_};
  const bool apart = by_source_.contains(source) || by_source_.size() < kMaxSources;
  auto& counts = apart ? by_source_[source] : by_others_;
  counts[static_cast<std::size_t>(drop)] += static_cast<std::uint64_t>(times);
}

std::vector<DropCount> WireGuard::drops() const {
  std::vector<DropCount> drops;
  {
    const std::lock_guard lock{mutex_};
    for (const auto& [source, counts] : by_source_) add(counts, dotted(source), drops);
    add(by_others_, "others", drops);
  }
  std::sort(drops.begin(), drops.end(),
            [](const DropCount& a, const DropCount& b) { return a.count > b.count; });
  return drops;
}

std::string summary(const std::vector<DropCount>& drops) {
  std::string text;
  for (const auto& drop : drops)
    text += fmt::format("{}{} {} from {}", text.empty() ? "" : ", ", drop.count, name(drop.drop),
                        drop.source);
  return text;
}

}  // namespace tandem::runtime
