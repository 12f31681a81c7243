// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/server_restarts.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "tandem/runtime/detail/rtps_payload.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::size_t kNumberAt = 2;  // of the server, in its prefix
constexpr std::uint8_t kOwnGuid = 0x50;
constexpr std::size_t kMostSources = 8;  // of a server, also before its restarts

// The source time that an INFO_TS gives to the submessages after it, seconds first; 0 if it
// invalidates the last one.
std::uint64_t time_of(const Submessage& timestamp) {
  constexpr std::uint8_t kInvalidate = 2;
  if ((timestamp.flags & kInvalidate) != 0 || timestamp.body.size() < 8) return 0;
  return std::uint64_t{timestamp.u32(0)} << 32 | timestamp.u32(4);
}

// Whether a participant announces itself, and not another one as a server does.
bool is_own_announcement(const Submessage& data, const GuidPrefix& prefix) {
  if (data.id != kData || data.entity(8) != kSpdpWriter) return false;
  const auto [list, little] = announced_list(data);
  const std::size_t guid = find_in_list(data.body, list, little, kOwnGuid);
  return guid + 4 + kPrefixSize <= data.body.size() &&
         prefix_at(data.body.data() + guid + 4) == prefix;
}

// Writes a little-endian datagram.
class DatagramWriter {
 public:
  DatagramWriter() { bytes_.reserve(256); }

  template <class Bytes>
  DatagramWriter& add(const Bytes& more) {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
    return *this;
  }
  template <std::size_t kSize>
  DatagramWriter& add(const std::uint8_t (&more)[kSize]) {
    bytes_.insert(bytes_.end(), std::begin(more), std::end(more));
    return *this;
  }
  DatagramWriter& add_number(std::int64_t number) {
    bytes_.resize(bytes_.size() + 8);
    put_sequence_number(bytes_.data() + bytes_.size() - 8, number, true);
    return *this;
  }
  DatagramWriter& add_entities() {  // of announcements: reader, writer
    return add({0x00, 0x01, 0x00, 0xc7, 0x00, 0x01, 0x00, 0xc2});
  }
  DatagramWriter& add_guid_of(const GuidPrefix& participant) {
    return add(participant).add({0x00, 0x00, 0x01, 0xc1});
  }
  [[nodiscard]] std::vector<std::uint8_t> bytes() && { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

// The writer of a submessage that contains announcements or describes which ones exist; 0 for other
// submessages.
std::uint32_t announcing_writer(const Submessage& submessage) {
  const bool has_data = submessage.id == kData || submessage.id == kDataFrag;
  const bool describes = submessage.id == kHeartbeat || submessage.id == kGap;
  if ((!has_data && !describes) || submessage.body.size() < 28) return 0;
  const std::uint32_t writer = submessage.entity(has_data ? 8 : 4);
  return announces(writer, kUnknownReader) ? writer : 0;
}

}  // namespace

bool is_server(const GuidPrefix& prefix) {
  constexpr GuidPrefix kServer{0x44, 0x53, 0x00, 0x5f, 0x45, 0x50,
                               0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
  GuidPrefix numberless = prefix;
  numberless[kNumberAt] = kServer[kNumberAt];
  return numberless == kServer;
}

bool ServerRestarts::Server::has(std::uint64_t source) const {
  return std::find(sources.begin(), sources.end(), source) != sources.end();
}

void ServerRestarts::Server::add(std::uint64_t source) {
  if (has(source)) return;
  if (sources.size() == kMostSources)
    sources.pop_back();  // a forged one must not push out the first
  sources.push_back(source);
}

bool ServerRestarts::Server::restarts(std::int64_t announced, std::uint64_t at, std::uint64_t from,
                                      double now) {
  const bool is_suspected = !sources.empty() && !has(from);
  if (at < time && !is_suspected) return false;  // an old one that was delayed
  const bool is_new = at != time && (announced <= number || is_suspected);
  if (is_new && restarted && now - *restarted < kLeastLife) return false;
  if (is_new) restarted = now;
  number = announced;
  time = at;
  suspected.reset();
  add(from);
  return is_new;
}

bool ServerRestarts::Server::suspects(std::uint64_t from, double now) {
  if (sources.empty()) add(from);
  if (has(from)) return false;
  const bool is_first = !suspected || now - *suspected > 2.0 * kLongestSuspicion;
  if (is_first) suspected = now;
  if (now - *suspected < kLongestSuspicion) return true;
  add(from);
  return false;
}

bool ServerRestarts::are_shown_by(std::span<std::uint8_t> datagram, std::uint64_t from,
                                  double now) {
  const GuidPrefix prefix = prefix_at(datagram.data() + kPrefixAt);
  Server& server = servers_[prefix];
  std::uint64_t time = 0;
  Submessage submessage;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    if (submessage.id == kInfoTimestamp) time = time_of(submessage);
    const std::uint32_t writer = announcing_writer(submessage);
    if (writer == 0) continue;
    if (time > 0 && is_own_announcement(submessage, prefix)) {
      if (server.restarts(submessage.sequence_number(12), time, from, now)) return true;
    } else if (server.suspects(from, now)) {
      mark_removed(bytes_of(datagram, submessage));
    }
  }
  return false;
}

std::vector<std::uint8_t> goodbye_of(const GuidPrefix& server, std::int64_t number) {
  // The server's key without data, with the status `disposed, unregistered`.
  DatagramWriter datagram;
  datagram.add({'R', 'T', 'P', 'S', 2, 3, 0x01, 0x0f}).add(server);
  datagram.add({kHeartbeat, 3, 28, 0}).add_entities();  // asks for no answer
  datagram.add_number(number).add_number(number).add({0xff, 0xff, 0xff, 0x7f});
  datagram.add({kData, 0x0b, 80, 0}).add({0, 0, 16, 0}).add_entities().add_number(number);
  datagram.add({0x70, 0, 16, 0}).add_guid_of(server);           // inline QoS: key hash,
  datagram.add({0x71, 0, 4, 0, 0, 0, 0, 3}).add({1, 0, 0, 0});  // status, end
  datagram.add({0, 3, 0, 0}).add({kOwnGuid, 0, 16, 0});         // key
  datagram.add_guid_of(server).add({1, 0, 0, 0});
  return std::move(datagram).bytes();
}

}  // namespace tandem::runtime
