// SPDX-License-Identifier: Apache-2.0
// Which files a recording consists of, and what metadata.yaml says about them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bringup/bag/bag_storage.hpp"

namespace tandem {

/// How the messages of a recording are stored.
enum class BagStorage { kMcap, kSqlite };

/// rosbag2's name of the storage: "mcap", "sqlite3".
[[nodiscard]] std::string name(BagStorage storage);

/// A topic and how many of its messages are recorded.
struct BagTopicCount {
  BagTopic topic;
  std::int64_t messages = 0;
};

/// What metadata.yaml says. Times [ns since 1970].
struct BagMetadata {
  BagStorage storage = BagStorage::kMcap;
  std::string file = {};  ///< its name in the folder
  std::int64_t messages = 0, first = 0, last = 0;
  std::vector<BagTopicCount> topics = {};
};

/// The metadata as YAML, without the topmost key: version 9 for MCAP, version 5 (Humble's) for
/// SQLite.
[[nodiscard]] std::string metadata_yaml(const BagMetadata& metadata);

/// Replaces the folder's metadata.yaml in one step, so that readers never see half a file.
void write_metadata(const std::string& folder, const std::string& yaml);

/// Rejects a recording whose metadata.yaml names a storage or a compression that cannot be read.
/// The file may be missing: the other files contain everything else. Throws std::runtime_error.
void check_metadata(const std::string& folder);

/// The files of a recording that hold messages: those of the folder, or the file itself. Throws
/// std::runtime_error if there is none.
[[nodiscard]] std::vector<std::string> bag_files(const std::string& path);

/// Whether the path is a folder or is named like a recording's file.
[[nodiscard]] bool is_recording(const std::string& path);

/// Opens a file for reading; its first bytes say which storage it is, not its name. A compressed
/// file is decompressed into the folder for temporary files; its space is freed with the reader.
/// Throws std::runtime_error if it is not a recording's or is damaged.
[[nodiscard]] std::unique_ptr<BagFileReader> open_bag_file(const std::string& file);

/// The command that makes this recording readable, phrased as the end of a sentence.
[[nodiscard]] std::string how_to_convert(const std::string& path);

}  // namespace tandem
