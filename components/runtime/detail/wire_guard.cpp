// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/wire_guard.hpp"

#include <algorithm>
#include <cstring>

#include <spdlog/fmt/fmt.h>

#include "tandem/runtime/detail/server_restarts.hpp"
#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/time.hpp"

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

WireGuard& WireGuard::shared() {
  static WireGuard guard{{.sample_size = largest_sample()}};
  return guard;
}

Drop WireGuard::fault_of(std::span<const std::uint8_t> datagram) const {
  GuardLimits limits = limits_;
  limits.all_protected = all_protected_;
  return check_datagram(datagram, limits);
}

bool WireGuard::admits(std::span<std::uint8_t> datagram, std::uint32_t source) {
  ++received_;
  if (const Drop drop = fault_of(datagram); drop != Drop::kNone) {
    if (drop != Drop::kGoodbye) count(drop, source);  // genuine goodbyes are not attacks
    return false;
  }
  // DDS Security authenticates the whole datagram, so any change would invalidate it.
  if (all_protected_ && is_protected(datagram)) return true;
  int far = 0, many = 0;
  {
    const double now = steady_seconds();
    const std::lock_guard lock{watch_mutex_};
    far = progress_.narrow(datagram, now);
    many = announcements_.thin(datagram, now);
  }
  if (far > 0) count(Drop::kSequence, source, far);
  if (many > 0) count(Drop::kAnnouncement, source, many);
  return true;
}

void WireGuard::sent(std::span<const std::uint8_t> datagram) {
  const double now = steady_seconds();
  const std::lock_guard lock{watch_mutex_};
  progress_.sent(datagram, now);
}

// The number lies far ahead of what any participant of this process has been told, so that none
// ignores the goodbye as known. Fast DDS counts through the numbers in between, in about 10 ms.
std::vector<std::uint8_t> WireGuard::take_leave_of_sender(std::span<const std::uint8_t> datagram) {
  const GuidPrefix server = prefix_at(datagram.data() + rtps_message::kPrefixAt);
  const std::lock_guard lock{watch_mutex_};
  const std::int64_t next = progress_.next(server, rtps_message::kSpdpWriter);
  progress_.forget(server);
  return goodbye_of(server, next + ReaderProgress::kStep);
}

WireGuard::Reported* WireGuard::claim_report(const void* who) {
  const void* nobody = nullptr;
  const bool its_own = reporter_.compare_exchange_strong(nobody, who) || nobody == who;
  return its_own ? &reported_ : nullptr;
}

void WireGuard::release_report(const void* who) { reporter_.compare_exchange_strong(who, nullptr); }

void WireGuard::count(Drop drop, std::uint32_t source, int times) {
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
