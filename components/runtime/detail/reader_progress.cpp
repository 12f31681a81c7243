// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/reader_progress.hpp"

#include <algorithm>
#include <cstdlib>

#include "tandem/runtime/detail/rtps_payload.hpp"
#include "tandem/runtime/detail/server_restarts.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::size_t kMaxWriters = 4096;  // maximum number of tracked writers
constexpr int kCandidates = 16;            // writers that are compared when one must be forgotten
// A forged count near the end of its range would leave too few for the writer's own HEARTBEATs.
constexpr std::uint32_t kMaxFirstCount = std::uint32_t{1} << 30;

ReaderProgressKey key_of(const GuidPrefix& prefix, const std::uint8_t* entity) {
  ReaderProgressKey key;
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

bool in_window(std::int64_t number, std::int64_t least, std::int64_t window) {
  return least == 0 || number - window <= least;
}

}  // namespace

// --- what a writer can have reached ---

bool WriterReach::believes(std::int64_t number, double now) {
  if (number >= kEnd) return false;
  if (top_ < 0 || number - leap_ <= top_) {
    claims_ = 0;
    know(number, now);
    return true;
  }
  if (static_cast<double>(number - leap_ - top_) > kFastest * (now - risen_)) return false;
  if (claims_ == 0 || std::abs(number - claimed_) >= kWindow) {
    claims_ = 0;
    first_claim_ = now;
  }
  claimed_ = number;
  if (++claims_ < kClaims || now - first_claim_ < kProofTime) return false;
  claims_ = 0;
  know(number, now);
  return true;
}

void WriterReach::know(std::int64_t number, double now) {
  if (number <= top_) return;
  top_ = number;
  risen_ = now;
}

// --- readers ---

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
}

// A reader ignores a HEARTBEAT whose count is not above the last one, so a forged count could make
// it ignore the writer's own. Counted here, each HEARTBEAT is above the last. One that is received
// again keeps its count.
std::uint32_t ReaderProgress::Source::renumbered(std::uint32_t writers_count) {
  if (passed > 0 && writers_count == count) return passed;
  count = writers_count;
  passed = passed == 0 ? std::clamp(writers_count, 1U, kMaxFirstCount) : passed + 1;
  return passed;
}

std::size_t ReaderProgress::KeyHash::operator()(const ReaderProgressKey& key) const {
  return mixed(bytes_at<std::uint64_t>(key.data()) ^
               mixed(bytes_at<std::uint64_t>(key.data() + 8)));
}

ReaderProgress::Source& ReaderProgress::of(const GuidPrefix& prefix, const std::uint8_t* entity) {
  const auto key = key_of(prefix, entity);
  if (const auto known = writers_.find(key); known != writers_.end()) return known->second;
  if (writers_.size() >= kMaxWriters) forget_one();
  if (is_server(prefix) && announces(rtps_message::entity(entity), 0))
    return writers_.try_emplace(key, kServerWindow, kServerWindow).first->second;
  return writers_.try_emplace(key, WriterReach::kLeap, kWindow).first->second;
}

// Forgets the least used of a few writers, and one that a reader has answered only among its
// like: forged GUIDs displace each other.
void ReaderProgress::forget_one() {
  std::size_t bucket = mixed(++forgotten_) % writers_.bucket_count();
  ReaderProgressKey least_used{};
  std::uint64_t least = ~std::uint64_t{0};
  for (int seen = 0; seen < kCandidates; bucket = (bucket + 1) % writers_.bucket_count())
    for (auto it = writers_.begin(bucket); it != writers_.end(bucket); ++it, ++seen) {
      const Source& source = it->second;
      const std::uint64_t use =
          (source.acknowledged ? std::uint64_t{1} << 32 : 0) + source.messages;
      if (use >= least) continue;
      least = use;
      least_used = it->first;
    }
  writers_.erase(least_used);
}

void ReaderProgress::sent(std::span<const std::uint8_t> datagram, double now) {
  GuidPrefix destination{};
  Submessage submessage;
  if (datagram.size() < kHeaderSize) return;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    const std::uint8_t* body = submessage.body.data();
    if (submessage.id == kInfoDestination && submessage.body.size() >= kPrefixSize)
      destination = prefix_at(body);
    if (submessage.id != kAckNack || submessage.body.size() < 16) continue;
    Source& source = of(destination, body + 4);
    source.acknowledged = true;
    const std::int64_t base = submessage.sequence_number(8);
    if (base <= 0) continue;  // a reader's first ACKNACK does not tell its progress
    if (base > WriterReach::kEnd)
      continue;  // no writer reaches it, and top() + kLeap would overflow
    source.acknowledge(submessage.entity(0), base);
    source.reach.know(base - 1, now);
  }
}

// Numbers farther ahead do not reach a reader that has acknowledged something. What the writer
// claims must not count: it can be forged, and Fast DDS counts up to the result.
std::int64_t ReaderProgress::beyond(const GuidPrefix& prefix, std::uint32_t writer) const {
  std::array<std::uint8_t, 4> entity;
  put_u32(entity.data(), writer, false);
  const auto known = writers_.find(key_of(prefix, entity.data()));
  const std::int64_t least = known == writers_.end() ? 0 : known->second.least(kUnknownReader);
  return least == 0 ? 1 + kStep : least + known->second.window + kWide + 1;
}

void ReaderProgress::forget(const GuidPrefix& prefix) {
  std::erase_if(writers_, [&](const auto& entry) {
    return std::equal(prefix.begin(), prefix.end(), entry.first.begin());
  });
}

// --- what arrives ---

int ReaderProgress::narrow(std::span<std::uint8_t> datagram, double now) {
  return take_out(datagram, [&](const Submessage& submessage, const GuidPrefix& source) {
    std::uint8_t* body = bytes_of(datagram, submessage);
    switch (submessage.id) {
      case kData:
      case kDataFrag:
        return passes_data(submessage, body, of(source, body + 8), now);
      case kHeartbeat:
        return passes_heartbeat(submessage, body, of(source, body + 4), now);
      case kGap:
        return passes_gap(submessage, body, of(source, body + 4), now);
      default:
        return true;
    }
  });
}

bool ReaderProgress::passes_data(const Submessage& data, std::uint8_t* body, Source& source,
                                 double now) {
  const std::int64_t number = data.sequence_number(12);
  const std::uint32_t reader = data.entity(4);
  if (!source.reach.believes(number, now)) return false;
  if (!in_window(number, source.least(reader), source.window)) {
    if (!source.catching_up) return false;
    mark_removed(body);  // no sign of an attack, so not counted
    return true;
  }
  ++source.messages;
  if (data.id == kData) source.advance(reader, number, number + 1);
  return true;
}

bool ReaderProgress::passes_heartbeat(const Submessage& heartbeat, std::uint8_t* body,
                                      Source& source, double now) {
  const bool little = heartbeat.little();
  const std::uint32_t reader = heartbeat.entity(0);
  std::int64_t first = heartbeat.sequence_number(8), last = heartbeat.sequence_number(16);
  if (!source.reach.believes(last, now)) {
    last = source.reach.top() + source.reach.leap();
    if (first - 1 > last) return false;
  }
  ++source.messages;
  const std::int64_t farthest = std::max<std::int64_t>(source.least(reader), 1) + kStep;
  source.catching_up = first > farthest;
  first = std::min(first, farthest);
  put_sequence_number(body + 8, first, little);
  put_sequence_number(body + 16, last, little);
  put_u32(body + 24, source.renumbered(heartbeat.u32(24)), little);
  source.advance(reader, 0, first);
  return true;
}

bool ReaderProgress::passes_gap(const Submessage& gap, std::uint8_t* body, Source& source,
                                double now) {
  const bool little = gap.little();
  const std::uint32_t reader = gap.entity(0);
  const std::int64_t first = gap.sequence_number(8), base = gap.sequence_number(16);
  if (!source.reach.believes(base - 1, now)) return false;
  const std::int64_t least = source.least(reader);
  if (base - first > kWide && least > 0 && first <= least) {
    const std::int64_t end = std::min(base, least + kStep);
    say_as_heartbeat(body, end, ++source.passed, little);
    source.advance(reader, first, end);
    return true;
  }
  const std::int64_t end = base - first > kWide ? first + kWide : base;
  if (!in_window(end, least, source.window)) return false;
  if (end < base) {  // pass only the first part, without the bitmap; the reader requests the rest
    put_sequence_number(body + 16, end, little);
    put_u32(body + 24, 0, little);
  }
  source.advance(reader, first, end);
  return true;
}

}  // namespace tandem::runtime
