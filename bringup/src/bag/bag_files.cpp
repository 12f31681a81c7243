// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag_files.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include <yaml-cpp/yaml.h>

#include "bringup/bag/bag_qos.hpp"
#include "bringup/bag/mcap_format.hpp"
#include "bringup/bag/mcap_reader.hpp"
#include "bringup/bag/sqlite_storage.hpp"
#include "bringup/bag/zstd.hpp"
#include "tandem/config/yaml_document.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr int kSqliteVersion = 5, kMcapVersion = 9;  // Humble's, Jazzy's
constexpr const char* kMetadataFile = "metadata.yaml";
constexpr const char* kTop = "rosbag2_bagfile_information";
constexpr std::array<std::string_view, 2> kPlain{".mcap", ".db3"};
constexpr std::string_view kCompressed = ".zstd";

void emit_topic(YAML::Emitter& out, const BagTopicCount& count, BagStorage storage) {
  const BagTopic& topic = count.topic;
  out << YAML::BeginMap << YAML::Key << "topic_metadata" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "name" << YAML::Value << topic.name;
  out << YAML::Key << "type" << YAML::Value << topic.type;
  out << YAML::Key << "serialization_format" << YAML::Value << "cdr";
  out << YAML::Key << "offered_qos_profiles" << YAML::Value;
  if (storage == BagStorage::kMcap) {
    emit_qos(out, topic.qos, QosForm::kWords);
    out << YAML::Key << "type_description_hash" << YAML::Value << YAML::DoubleQuoted
        << topic.type_hash;
  } else {
    out << YAML::DoubleQuoted << qos_yaml(topic.qos, QosForm::kNumbers);
  }
  out << YAML::EndMap;
  out << YAML::Key << "message_count" << YAML::Value << count.messages << YAML::EndMap;
}

void emit_span(YAML::Emitter& out, const BagMetadata& metadata) {
  out << YAML::Key << "duration" << YAML::Value << YAML::BeginMap << YAML::Key << "nanoseconds"
      << YAML::Value << metadata.last - metadata.first << YAML::EndMap;
  out << YAML::Key << "starting_time" << YAML::Value << YAML::BeginMap << YAML::Key
      << "nanoseconds_since_epoch" << YAML::Value << metadata.first << YAML::EndMap;
  out << YAML::Key << "message_count" << YAML::Value << metadata.messages;
}

bool is_named_plain(const std::string& file) {
  return std::any_of(kPlain.begin(), kPlain.end(),
                     [&](std::string_view ending) { return file.ends_with(ending); });
}

bool is_named_compressed(const std::string& file) {
  return file.ends_with(kCompressed) &&
         is_named_plain(file.substr(0, file.size() - kCompressed.size()));
}

// A temporary folder, removed with its contents at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_{fs::temp_directory_path() / "tandem_bag_XXXXXX"} {
    std::string name = path_.string();
    if (mkdtemp(name.data()) == nullptr)
      throw std::runtime_error(name + ": cannot be created; choose another folder with TMPDIR");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// The file's first bytes; fewer if it is shorter or cannot be read.
std::vector<std::uint8_t> first_bytes(const fs::path& file) {
  std::ifstream in{file, std::ios::binary};
  std::array<char, mcap::kMagic.size()> bytes{};
  in.read(bytes.data(), bytes.size());
  return {bytes.begin(), bytes.begin() + in.gcount()};
}

// `name`: the file that the user named, for messages. A temporary file is unlinked once it is open.
std::unique_ptr<BagFileReader> open_plain(const fs::path& file, const std::string& name,
                                          bool is_temporary) {
  if (std::ranges::equal(first_bytes(file), mcap::kMagic))
    return std::make_unique<McapReader>(file, name);
  return std::make_unique<SqliteReader>(file, name, is_temporary);
}

}  // namespace

std::string name(BagStorage storage) { return storage == BagStorage::kMcap ? "mcap" : "sqlite3"; }

std::string metadata_yaml(const BagMetadata& metadata) {
  const bool is_mcap = metadata.storage == BagStorage::kMcap;
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "version" << YAML::Value
      << (is_mcap ? kMcapVersion : kSqliteVersion);
  out << YAML::Key << "storage_identifier" << YAML::Value << name(metadata.storage);
  emit_span(out, metadata);
  out << YAML::Key << "topics_with_message_count" << YAML::Value << YAML::BeginSeq;
  for (const auto& count : metadata.topics) emit_topic(out, count, metadata.storage);
  out << YAML::EndSeq;
  out << YAML::Key << "compression_format" << YAML::Value << YAML::DoubleQuoted << "";
  out << YAML::Key << "compression_mode" << YAML::Value << YAML::DoubleQuoted << "";
  out << YAML::Key << "relative_file_paths" << YAML::Value << YAML::BeginSeq << metadata.file
      << YAML::EndSeq;
  out << YAML::Key << "files" << YAML::Value << YAML::BeginSeq << YAML::BeginMap;
  out << YAML::Key << "path" << YAML::Value << metadata.file;
  emit_span(out, metadata);
  out << YAML::EndMap << YAML::EndSeq;
  if (is_mcap) {
    out << YAML::Key << "custom_data" << YAML::Value << YAML::BeginMap << YAML::EndMap;
    out << YAML::Key << "ros_distro" << YAML::Value << "jazzy";
  }
  out << YAML::EndMap;
  return out.c_str();
}

void write_metadata(const std::string& folder, const std::string& yaml) {
  const fs::path path = fs::path{folder} / kMetadataFile;
  const fs::path fresh = path.string() + ".new";
  std::ofstream out{fresh};
  out << kTop << ":\n  ";
  for (const char c : yaml) {
    out << c;
    if (c == '\n') out << "  ";
  }
  out << '\n';
  out.close();
  fs::rename(fresh, path);
}

void check_metadata(const std::string& folder) {
  const std::string file = fs::path{folder} / kMetadataFile;
  const auto refuse = [&](const std::string& field, const std::string& value,
                          const std::string& readable) {
    throw std::runtime_error(file + ": " + field + " is '" + value + "', not " + readable + ";" +
                             how_to_convert(folder));
  };
  std::string storage, format;
  try {
    const YAML::Node info = load_document(file)[kTop];
    storage = info["storage_identifier"].as<std::string>("");
    format = info["compression_format"].as<std::string>("");
  } catch (const std::exception&) {
    return;  // a killed recorder leaves no metadata
  }
  if (!storage.empty() && storage != "mcap" && storage != "sqlite3")
    refuse("storage_identifier", storage, "mcap or sqlite3");
  if (!format.empty() && format != "zstd") refuse("compression_format", format, "zstd");
}

std::vector<std::string> bag_files(const std::string& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator{path}) {
    const std::string file = entry.path();
    // rosbag2 leaves a decompressed file next to the compressed original.
    const bool is_copy =
        is_named_compressed(file) && fs::exists(fs::path{file}.replace_extension());
    if ((is_named_plain(file) || is_named_compressed(file)) && !is_copy) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  if (!files.empty()) return files;
  throw std::runtime_error(path + " contains no .mcap and no .db3; is it a recording?");
}

bool is_recording(const std::string& path) {
  return fs::is_directory(path) || is_named_plain(path) || is_named_compressed(path);
}

std::unique_ptr<BagFileReader> open_bag_file(const std::string& file) {
  if (!is_zstd(first_bytes(file))) return open_plain(file, file, false);
  const TemporaryFolder folder;
  const fs::path plain = folder.path() / "plain";
  try {
    decompress_file(file, plain);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file + ": " + error.what());
  }
  return open_plain(plain, file, true);
}

std::string how_to_convert(const std::string& path) {
  return " convert it: ros2 bag convert -i " + path +
         " -o out.yaml, where out.yaml holds output_bags: [{uri: converted, storage_id: mcap, "
         "all: true, rmw_serialization_format: cdr}]";
}

}  // namespace tandem
