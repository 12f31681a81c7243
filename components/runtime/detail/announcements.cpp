// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/announcements.hpp"

#include <algorithm>
#include <new>
#include <random>

#include "tandem/runtime/detail/rtps_payload.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::size_t kSlots = std::size_t{1} << 16;
constexpr int kEndpointsOfAll = 24;          // per participant, exempt from the rate limit
constexpr std::int64_t kFarthestNext = 256;  // maximum step of an endpoint's number
constexpr double kBytesPerToken = 2048.0;    // announcement size per extra token [bytes]
constexpr double kLookPeriod = 5.0;          // [s] between checks for expired leases
constexpr std::uint16_t kLeaseDuration = 0x02;

// Returns how long Fast DDS keeps a silent participant [s]. A lease longer than kLongestLease is
// overwritten.
double shortened_lease(std::uint8_t* body, const Submessage& announcement) {
  constexpr double kLongest = Announcements::kLongestLease;
  if (announcement.id != kData) return kLongest;
  const auto [list, little] = announced_list(announcement);
  const std::size_t at = find_in_list(announcement.body, list, little, kLeaseDuration);
  if (at + 8 > announcement.body.size()) return kLongest;
  const std::uint32_t seconds = u32(body + at + 4, little);
  if (seconds < kLongest) return 1.0 + seconds;
  put_u32(body + at + 4, static_cast<std::uint32_t>(kLongest), little);
  return kLongest;
}

}  // namespace

std::size_t GuidPrefixHash::operator()(const GuidPrefix& prefix) const {
  const auto low = bytes_at<std::uint64_t>(prefix.data());
  return mixed(mixed(low ^ seed) + bytes_at<std::uint32_t>(prefix.data() + 8));
}

bool TokenBucket::take(double tokens, double now) {
  left_ = std::min(burst_, left_ + (now - last_) * rate_);
  last_ = now;
  if (left_ < tokens) return false;
  left_ -= tokens;
  return true;
}

Announcements::Announcements()
    : hash_{std::random_device{}() * 0x100000001ULL},
      known_{64, hash_},
      // calloc: the 1 MB takes no memory until participants are seen.
      seen_{static_cast<Seen*>(std::calloc(kSlots, sizeof(Seen)))} {
  if (seen_ == nullptr) throw std::bad_alloc{};
}

int Announcements::thin(std::span<std::uint8_t> datagram, double now) {
  return take_out(datagram, [&](const Submessage& submessage, const GuidPrefix& source) {
    if (submessage.id != kData && submessage.id != kDataFrag) return true;
    const std::uint32_t writer = submessage.entity(8);
    if (writer == kSpdpWriter)
      return admits_participant(source, shortened_lease(bytes_of(datagram, submessage), submessage),
                                now);
    if (writer != kSedpPublicationsWriter && writer != kSedpSubscriptionsWriter) return true;
    return admits_endpoint(source, writer == kSedpSubscriptionsWriter,
                           submessage.sequence_number(12), submessage.body.size(), now);
  });
}

bool Announcements::admits_participant(const GuidPrefix& prefix, double lease, double now) {
  forget(now);
  if (const auto known = known_.find(prefix); known != known_.end()) {
    known->second.until = now + lease;
    return true;
  }
  const std::size_t hash = hash_(prefix);
  Seen& seen = seen_[hash % kSlots];
  const auto mark = static_cast<std::uint32_t>(hash >> 32) | 1U;
  const bool again = seen.mark == mark && now - seen.at > kSecondSight;
  if (seen.mark != mark) seen = {mark, now};
  if (!first_sight_.take(1, now) && !(again && second_sight_.take(1, now))) return false;
  known_.emplace(prefix, Known{now + lease, {0, 0}, 0});
  return true;
}

bool Announcements::admits_endpoint(const GuidPrefix& prefix, int kind, std::int64_t number,
                                    std::size_t size, double now) {
  const auto found = known_.find(prefix);
  Known* known = found == known_.end() ? nullptr : &found->second;
  if (known != nullptr && number <= known->last[kind]) return true;  // repetition
  const double tokens = 1.0 + static_cast<double>(size) / kBytesPerToken;
  const bool of_all = known != nullptr && known->endpoints < kEndpointsOfAll && tokens < 2.0;
  if (!of_all && !endpoints_.take(tokens, now)) return false;
  if (known == nullptr) return true;
  if (number - kFarthestNext <= known->last[kind]) known->last[kind] = number;
  ++known->endpoints;
  return true;
}

void Announcements::forget(double now) {
  if (now < next_look_) return;
  next_look_ = now + kLookPeriod;
  std::erase_if(known_, [&](const auto& entry) { return entry.second.until < now; });
}

}  // namespace tandem::runtime
