// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <type_hashes.hpp>
#include <utility>

#include "bringup/bag/mcap_writer.hpp"
#include "bringup/bag/sqlite_storage.hpp"
#include "bringup/bag/zstd.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLongestPause = 86'400'000'000'000;  // [ns] one day
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();

}  // namespace

BagWriter::BagWriter(const std::string& folder, BagStorage storage) : folder_{folder} {
  if (fs::exists(folder)) throw std::runtime_error(folder + " already exists");
  fs::create_directories(folder);
  const fs::path path{folder};
  const std::string stem = path.has_filename() ? path.filename() : path.parent_path().filename();
  const bool is_mcap = storage == BagStorage::kMcap;
  metadata_.storage = storage;
  metadata_.file = stem + (is_mcap ? "_0.mcap" : "_0.db3");
  const std::string file = path / metadata_.file;
  if (is_mcap)
    file_ = std::make_unique<McapWriter>(file);
  else
    file_ = std::make_unique<SqliteWriter>(file);
  write_metadata(folder_, metadata_yaml(metadata_));
}

BagWriter::~BagWriter() {
  try {
    commit();
    file_->close(metadata_yaml(metadata_));
  } catch (const std::exception&) {  // reported before, or the disk is full: nothing left to do
  }
}

int BagWriter::add_topic(const BagTopic& topic) {
  BagTopic added = topic;
  if (const auto* type = rt::described_type(topic.type); type != nullptr && added.type_hash.empty())
    added.type_hash = type->hash;
  metadata_.topics.push_back({added, 0});
  const int id = static_cast<int>(metadata_.topics.size());
  file_->add_topic(id, added);
  return id;
}

void BagWriter::write(int topic, std::int64_t time, const std::vector<std::uint8_t>& bytes) {
  file_->write(topic, time, bytes);
  if (metadata_.messages++ == 0) metadata_.first = metadata_.last = time;
  metadata_.first = std::min(metadata_.first, time);
  metadata_.last = std::max(metadata_.last, time);
  ++metadata_.topics.at(static_cast<std::size_t>(topic) - 1).messages;
}

void BagWriter::commit() {
  file_->flush();
  write_metadata(folder_, metadata_yaml(metadata_));
}

BagReader::BagReader(const std::string& path) {
  check_metadata(fs::is_directory(path) ? path : fs::path{path}.parent_path().string());
  for (const auto& file : bag_files(path)) add(file);
  std::stable_sort(files_.begin(), files_.end(), [](const File& a, const File& b) {
    return a.reader->first() > b.reader->first();
  });
}

void BagReader::add(const std::string& file) {
  File& added = files_.emplace_back();
  added.name = file;
  added.reader = open_bag_file(file);
  for (const BagTopic& topic : added.reader->topics()) {
    const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& other) {
      return other.name == topic.name && other.type == topic.type;
    });
    added.index.push_back(static_cast<std::size_t>(known - topics_.begin()));
    if (known == topics_.end()) topics_.push_back(topic);
  }
}

bool BagReader::next(BagMessage& message) {
  for (; !files_.empty(); files_.pop_back()) {
    const File& file = files_.back();
    if (!file.reader->next(message)) continue;
    message.topic = file.index.at(message.topic);
    message.time = without_gap(message.time);
    decompress_message(message);
    return true;
  }
  return false;
}

void BagReader::decompress_message(BagMessage& message) const {
  if (!is_zstd(message.bytes)) return;
  try {
    message.bytes = decompress(message.bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(files_.back().name + ": a message is damaged: " + error.what());
  }
}

// Timestamps increase, except where consecutive files overlap by a few nanoseconds.
std::int64_t BagReader::without_gap(std::int64_t stamp) {
  const std::int64_t gap = last_stamp_ ? stamp - *last_stamp_ : 0;
  if (gap > kLongestPause && gap <= kLatest - skipped_) skipped_ += gap;
  last_stamp_ = stamp;
  return stamp - skipped_;
}

}  // namespace tandem
