// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/rtps_watch.hpp"

#include <algorithm>
#include <limits>
#include <random>

#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::uint8_t kTakenOut = 0x7f;   // unassigned submessage id, which readers skip
constexpr std::size_t kMaxWriters = 4096;  // maximum number of tracked writers
constexpr std::size_t kSlots = std::size_t{1} << 16;
constexpr int kEndpointsOfAll = 24;          // per participant, exempt from the rate limit
constexpr std::int64_t kFarthestNext = 256;  // maximum step of an endpoint's number
constexpr double kBytesPerToken = 2048.0;    // announcement size per extra token [bytes]
constexpr double kLookPeriod = 5.0;          // [s] between checks for expired leases
constexpr std::uint16_t kLeaseDuration = 0x02, kSentinel = 0x01;

GuidPrefix prefix_at(const std::uint8_t* p) {
  GuidPrefix prefix;
  std::memcpy(prefix.data(), p, prefix.size());
  return prefix;
}

std::uint64_t mixed(std::uint64_t value) {
  value ^= value >> 33;
  value *= 0xff51afd7ed558ccdULL;
  return value ^ value >> 33;
}

template <class T>
T bytes_at(const std::uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

void put_u32(std::uint8_t* p, std::uint32_t value, bool little) {
  for (int i = 0; i < 4; ++i) p[little ? i : 3 - i] = static_cast<std::uint8_t>(value >> 8 * i);
}
void put_sequence_number(std::uint8_t* p, std::int64_t value, bool little) {
  put_u32(p, static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32), little);
  put_u32(p + 4, static_cast<std::uint32_t>(value), little);
}

template <class Key>
Key key_of(const GuidPrefix& prefix, const std::uint8_t* entity) {
  Key key;
  std::memcpy(key.data(), prefix.data(), prefix.size());
  std::memcpy(key.data() + prefix.size(), entity, key.size() - prefix.size());
  return key;
}

// Rewrites a GAP up to `first` as the HEARTBEAT of a writer that holds nothing before `first`. For
// a reader that misses nothing before the GAP the effect is the same. Requests no response.
void say_as_heartbeat(std::uint8_t* body, std::int64_t first, std::uint32_t count, bool little) {
  constexpr std::uint8_t kFinal = 2;
  body[-4] = kHeartbeat;
  body[-3] = static_cast<std::uint8_t>(kFinal | (little ? 1 : 0));
  put_sequence_number(body + 8, first, little);
  put_sequence_number(body + 16, first - 1, little);
  put_u32(body + 24, count, little);
}

// Offset of the parameter in the list that begins at `at`; bytes.size() if it is missing.
std::size_t find_in_list(Span bytes, std::size_t at, bool little, std::uint16_t wanted) {
  while (at + 4 <= bytes.size()) {
    const std::uint16_t id = u16(bytes.data() + at, little);
    if (id == wanted) return at;
    at += 4;
    if (id == kSentinel) break;
    at += (u16(bytes.data() + at - 2, little) + std::size_t{3}) & ~std::size_t{3};
  }
  return bytes.size();
}

// Returns how long Fast DDS keeps a silent participant [s]. A lease longer than kLongestLease is
// overwritten.
double shortened_lease(std::uint8_t* body, const Submessage& announcement) {
  constexpr std::uint8_t kInlineQos = 2, kHasData = 4;
  constexpr double kLongest = Announcements::kLongestLease;
  if (announcement.id != kData || (announcement.flags & kHasData) == 0) return kLongest;
  std::size_t at = std::size_t{4} + announcement.u16(2);
  if ((announcement.flags & kInlineQos) != 0)
    at = find_in_list(announcement.body, at, announcement.little(), kSentinel) + 4;
  if (at + 4 > announcement.body.size()) return kLongest;
  const bool little = body[at + 1] == 3;
  at = find_in_list(announcement.body, at + 4, little, kLeaseDuration);
  if (at + 8 > announcement.body.size()) return kLongest;
  const std::uint32_t seconds = u32(body + at + 4, little);
  if (seconds < kLongest) return 1.0 + seconds;
  put_u32(body + at + 4, static_cast<std::uint32_t>(kLongest), little);
  return kLongest;
}

std::uint8_t* bytes_of(std::span<std::uint8_t> datagram, const Submessage& submessage) {
  return datagram.data() + (submessage.body.data() - datagram.data());
}

// Calls `visit(submessage, source prefix)` for each submessage and removes it if that returns
// false.
template <class Visit>
int take_out(std::span<std::uint8_t> datagram, Visit visit) {
  GuidPrefix source = prefix_at(datagram.data() + kPrefixAt);
  Submessage submessage;
  int taken = 0;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    if (submessage.id == kInfoSource) source = prefix_at(submessage.body.data() + 8);
    if (visit(submessage, source)) continue;
    bytes_of(datagram, submessage)[-4] = kTakenOut;
    ++taken;
  }
  return taken;
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

// --- reader progress ---

std::size_t ReaderProgress::KeyHash::operator()(const Key& key) const {
  return mixed(bytes_at<std::uint64_t>(key.data()) ^
               mixed(bytes_at<std::uint64_t>(key.data() + 8)));
}

std::int64_t ReaderProgress::Source::least(std::uint32_t reader) const {
  std::int64_t least = 0;
  for (const Progress& progress : readers)
    if (reader == kUnknownReader || reader == progress.reader)
      least = least == 0 ? progress.next : std::min(least, progress.next);
  return least;
}

void ReaderProgress::Source::advance(std::uint32_t reader, std::int64_t from, std::int64_t to) {
  for (Progress& progress : readers)
    if (reader == kUnknownReader || reader == progress.reader)
      if (from <= progress.next && progress.next < to) progress.next = to;
}

void ReaderProgress::Source::acknowledge(std::uint32_t reader, std::int64_t base) {
  const auto known = std::find_if(readers.begin(), readers.end(),
                                  [&](const Progress& p) { return p.reader == reader; });
  if (known == readers.end())
    readers.push_back({reader, base});
  else
    known->next = base;
  top = std::max(top, base - 1);
}

bool ReaderProgress::Source::believes(std::int64_t first, bool usual_count, std::int64_t order) {
  const bool again = claimed > 0 && first >= claimed && first - claimed < kWindow &&
                     order > claimed_order && order - claimed_order < kCounts;
  if (!again && !(usual_count && first - kLeap - 1 <= top)) {
    claimed = first;
    claimed_order = order;
    return false;
  }
  claimed = 0;
  top = std::max(top, first - 1);
  return true;
}

ReaderProgress::Source* ReaderProgress::find(const GuidPrefix& prefix, const std::uint8_t* entity) {
  const auto found = writers_.find(key_of<Key>(prefix, entity));
  return found == writers_.end() ? nullptr : &found->second;
}

// Above kMaxWriters an arbitrary writer is forgotten until its next message.
ReaderProgress::Source& ReaderProgress::of(const GuidPrefix& prefix, const std::uint8_t* entity) {
  if (Source* known = find(prefix, entity)) return *known;
  if (writers_.size() >= kMaxWriters) writers_.erase(writers_.begin());
  return writers_[key_of<Key>(prefix, entity)];
}

void ReaderProgress::sent(std::span<const std::uint8_t> datagram) {
  GuidPrefix destination{};
  Submessage submessage;
  if (datagram.size() < kHeaderSize) return;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    const std::uint8_t* body = submessage.body.data();
    if (submessage.id == kInfoDestination && submessage.body.size() >= kPrefixSize)
      destination = prefix_at(body);
    if (submessage.id != kAckNack || submessage.body.size() < 16) continue;
    const std::int64_t base = submessage.sequence_number(8);
    if (base <= 0) continue;  // a reader's first ACKNACK says nothing about its progress
    of(destination, body + 4).acknowledge(submessage.entity(0), base);
  }
}

int ReaderProgress::narrow(std::span<std::uint8_t> datagram) {
  return take_out(datagram, [&](const Submessage& submessage, const GuidPrefix& source) {
    switch (submessage.id) {
      case kData:
      case kDataFrag:
        return passes_data(submessage, of(source, submessage.body.data() + 8));
      case kHeartbeat:
        return passes_heartbeat(submessage, find(source, submessage.body.data() + 4));
      case kGap:
        return passes_gap(submessage, bytes_of(datagram, submessage),
                          find(source, submessage.body.data() + 4));
      default:
        return true;
    }
  });
}

bool ReaderProgress::in_window(std::int64_t number, std::int64_t least) {
  return least == 0 || number <= kWindow || number - kWindow <= least;
}

bool ReaderProgress::passes_data(const rtps_message::Submessage& data, Source& source) {
  const std::int64_t number = data.sequence_number(12);
  const std::uint32_t reader = data.entity(4);
  if (source.top == 0) source.top = number;  // the first sample seen from this writer
  if (!source.believes(number, true, number) || !in_window(number, source.least(reader)))
    return false;
  constexpr auto kLast = std::numeric_limits<std::int64_t>::max();
  source.top = std::max(source.top, number);
  if (data.id == kData && number < kLast) source.advance(reader, number, number + 1);
  return true;
}

bool ReaderProgress::passes_heartbeat(const rtps_message::Submessage& heartbeat, Source* source) {
  if (source == nullptr) return true;
  const std::int64_t first = heartbeat.sequence_number(8);
  const std::uint32_t count = heartbeat.u32(24);
  const bool usual = source->heartbeats == 0 ||
                     static_cast<std::uint32_t>(count - source->heartbeats) < kCounts ||
                     static_cast<std::uint32_t>(source->heartbeats - count) < kCounts;
  if (!source->believes(first, usual, count)) return false;
  source->heartbeats = count;
  source->advance(heartbeat.entity(0), 0, first);
  return true;
}

bool ReaderProgress::passes_gap(const rtps_message::Submessage& gap, std::uint8_t* body,
                                Source* source) {
  const bool little = gap.little();
  const std::uint32_t reader = gap.entity(0);
  const std::int64_t first = gap.sequence_number(8), base = gap.sequence_number(16);
  const std::int64_t least = source == nullptr ? 0 : source->least(reader);
  if (source != nullptr && !source->believes(base, true, ++source->gaps)) return false;
  if (base - first > kWide && least > 0 && first <= least) {
    say_as_heartbeat(body, base, ++source->heartbeats, little);
    source->advance(reader, first, base);
    return true;
  }
  const std::int64_t end = base - first > kWide ? first + kWide : base;
  if (!in_window(end, least)) return false;
  if (end < base) {  // pass only the first part, without the bitmap; the reader requests the rest
    put_sequence_number(body + 16, end, little);
    put_u32(body + 24, 0, little);
  }
  if (source != nullptr) source->advance(reader, first, end);
  return true;
}

// --- announcements ---

Announcements::Announcements()
    : hash_{std::random_device{}() * 0x100000001ULL}, known_{64, hash_}, seen_(kSlots) {}

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
