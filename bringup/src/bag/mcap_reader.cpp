// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/mcap_reader.hpp"

#include <algorithm>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <utility>

#include "bringup/bag/bag_files.hpp"
#include "bringup/bag/bag_qos.hpp"
#include "tandem/runtime/log.hpp"

namespace tandem {
namespace {

// Chunks that overlap in time are held in memory together up to this size [bytes]. With more, the
// order of messages is that of the file.
constexpr std::size_t kMostHeld = std::size_t{256} << 20U;
constexpr std::uint64_t kLatestStamp = std::numeric_limits<std::int64_t>::max();  // [ns]

void warn_once(const std::string& file, std::uint64_t cut_at) {
  static std::mutex mutex;
  static std::set<std::string> warned;
  const std::lock_guard lock{mutex};
  if (!warned.insert(file).second) return;
  rt::Logger{"tandem"}.warn(
      "{}: has no end, as when its recorder was killed or is still recording; reading what is "
      "there, "
      "up to byte {}",
      file, cut_at);
}

// "pkg/Type", as some writers call a type, is "pkg/msg/Type".
std::string full_type(const std::string& schema) {
  const auto slash = schema.find('/');
  if (slash == std::string::npos || schema.find('/', slash + 1) != std::string::npos) return schema;
  return schema.substr(0, slash) + "/msg" + schema.substr(slash);
}

std::string value(const mcap::Channel& channel, const char* key) {
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? "" : found->second;
}

}  // namespace

McapReader::McapReader(const std::filesystem::path& file, const std::string& name)
    : file_{file, name}, contents_{mcap::scan(file_)} {
  if (contents_.cut_at) warn_once(name, *contents_.cut_at);
  for (const auto& [id, channel] : contents_.channels) add_topic(channel);
  std::stable_sort(contents_.places.begin(), contents_.places.end(),
                   [](const auto& a, const auto& b) { return a.start < b.start; });
}

void McapReader::add_topic(const mcap::Channel& channel) {
  if (channel.encoding != "cdr")
    throw std::runtime_error(file_.name() + ": serialization_format of " + channel.topic + " is '" +
                             channel.encoding + "', not cdr;" + how_to_convert(file_.name()));
  const auto schema = contents_.schemas.find(channel.schema);
  const std::string type = schema == contents_.schemas.end() ? "" : full_type(schema->second.name);
  index_[channel.id] = topics_.size();
  topics_.push_back({channel.topic, type,
                     recorded_qos(channel.topic, value(channel, "offered_qos_profiles")),
                     value(channel, "topic_type_hash")});
}

std::int64_t McapReader::first() const {
  for (const mcap::Place& place : contents_.places)  // chunks without messages begin at 0
    if (place.start > 0) return static_cast<std::int64_t>(std::min(place.start, kLatestStamp));
  return 0;
}

bool McapReader::next(BagMessage& message) {
  const auto& places = contents_.places;
  while (next_place_ < places.size() &&
         (waiting_.empty() ||
          (held_ < kMostHeld &&
           places[next_place_].start <= static_cast<std::uint64_t>(waiting_.top().time))))
    load(places[next_place_++]);
  if (waiting_.empty()) return false;
  const Waiting next = waiting_.top();
  waiting_.pop();
  message.topic = next.topic;
  message.time = next.time;
  const auto data = mcap::View{next.block->bytes}.subspan(next.offset, next.size);
  message.bytes.assign(data.begin(), data.end());
  if (--next.block->messages == 0) held_ -= next.block->bytes.size();
  return true;
}

void McapReader::load(const mcap::Place& place) {
  const auto block = std::make_shared<Block>();
  try {
    if (place.is_chunk) {
      block->bytes = mcap::records_of(file_, place);
      mcap::for_each_record(block->bytes, [&](mcap::Op op, mcap::View content, std::size_t at) {
        if (op == mcap::Op::kMessage) add_message(place, block, content, at);
      });
    } else {
      block->bytes = file_.read(place.offset, place.size);
      add_message(place, block, block->bytes, 0);
    }
  } catch (const mcap::ShortRecord& error) {
    file_.fail(place.offset, error.what());
  }
  if (block->messages > 0) held_ += block->bytes.size();
}

void McapReader::add_message(const mcap::Place& place, const std::shared_ptr<Block>& block,
                             mcap::View content, std::size_t offset) {
  mcap::Input in{content};
  const mcap::Message message = in.message();
  const auto topic = index_.find(message.channel);
  if (topic == index_.end())
    file_.fail(place.offset, "a message is of channel " + std::to_string(message.channel) +
                                 ", which the file does not describe");
  ++block->messages;
  waiting_.push({static_cast<std::int64_t>(std::min(message.time, kLatestStamp)), order_++,
                 topic->second, offset + content.size() - in.rest().size(), in.rest().size(),
                 block});
}

}  // namespace tandem
