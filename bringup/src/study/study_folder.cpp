// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/checksum.hpp"
#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

// The first key in which two descriptions differ. The name is compared first, because the files of
// another study differ too.
std::string difference(const nlohmann::json& kept, const nlohmann::json& asked) {
  if (kept.value("study", nlohmann::json{}) != asked.value("study", nlohmann::json{}))
    return "study";
  for (const auto& [key, value] : asked.items())
    if (!kept.contains(key) || kept.at(key) != value) return key;
  return "its list of files";
}

void write_all(int file, const std::string& text, const std::string& name) {
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t n = write(file, text.data() + written, text.size() - written);
    if (n < 0 && errno != EINTR) fail(name, std::strerror(errno));
    if (n > 0) written += static_cast<std::size_t>(n);
  }
}

// Reads through the locked descriptor: closing any other descriptor of the file would release the
// lock.
std::string text_of(int file) {
  std::string all;
  char part[65536];
  for (ssize_t n = 1; n > 0; all.append(part, static_cast<std::size_t>(std::max<ssize_t>(0, n))))
    n = pread(file, part, sizeof part, static_cast<off_t>(all.size()));
  return all;
}

}  // namespace

StudyFolder::StudyFolder(const std::string& folder, const nlohmann::json& study)
    : folder_{folder}, order_{study.at("drives").get<std::vector<std::string>>()} {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) fail(folder_, error.message() + "; choose a folder that exists or can be created");
  const std::string name = folder_ + "/drives.jsonl";
  file_ = open(name.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail(name, std::strerror(errno));
  try {
    struct flock whole {};  // child processes do not inherit this lock
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (fcntl(file_, F_SETLK, &whole) != 0)
      fail(folder_, "another process is writing there; wait for it, or choose another folder");
    claim(study);
    read_back();
  } catch (...) {
    close(file_);
    throw;
  }
}

StudyFolder::~StudyFolder() { close(file_); }

void StudyFolder::claim(const nlohmann::json& study) {
  const std::string file = folder_ + "/study.json";
  if (!fs::exists(file)) return write_file(file, study.dump(1) + "\n");
  const nlohmann::json kept = read_study(folder_);
  if (kept == study) return;
  throw std::invalid_argument(folder_ + ": contains another study (" +
                              difference(kept.at("description"), study.at("description")) +
                              " differs); choose another folder, or remove this one");
}

void StudyFolder::read_back() {
  const std::string name = folder_ + "/drives.jsonl";
  const std::string text = text_of(file_);
  std::size_t begin = 0, number = 1;
  for (auto end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin), ++number) {
    const auto line = parse_json_or_null(text.substr(begin, end - begin));
    if (!line.is_object() || !line.contains("name") || !line.contains("drive"))
      fail(name + ":" + std::to_string(number), "not a finished drive; remove the line");
    try {
      (void)line.at("drive").get<DriveResult>();
    } catch (const nlohmann::json::exception&) {
      fail(name + ":" + std::to_string(number),
           "a drive of another version of tandem; choose another folder, or remove the line");
    }
    finished_.emplace(line.at("name").get<std::string>(), line);
  }
  if (begin < text.size() && ftruncate(file_, static_cast<off_t>(begin)) != 0)
    fail(name, std::strerror(errno));
}

std::vector<DriveResult> StudyFolder::results() const {
  std::vector<DriveResult> results;
  for (const auto& name : order_)
    if (const auto it = finished_.find(name); it != finished_.end())
      results.push_back(it->second.at("drive").get<DriveResult>());
  return results;
}

std::map<std::string, std::size_t> StudyFolder::builds() const {
  std::map<std::string, std::size_t> builds;
  for (const auto& [name, line] : finished_) ++builds[line.value("build", "")];
  return builds;
}

void StudyFolder::append(const std::string& name, nlohmann::json line) {
  line["name"] = name;
  if (!line.contains("build")) line["build"] = this_build();
  const std::string file = folder_ + "/drives.jsonl";
  write_all(file_, line.dump() + "\n", file);
  if (fsync(file_) != 0) fail(file, std::strerror(errno));
  finished_.insert_or_assign(name, std::move(line));
}

const std::string& this_build() {
  static const std::string build = [] {
    std::ifstream in{"/proc/self/exe", std::ios::binary};
    const std::string program{std::istreambuf_iterator<char>{in}, {}};
    return fmt::format("{:016x}", checksum(program));
  }();
  return build;
}

nlohmann::json contents_of(const Study& study) {
  nlohmann::json names = nlohmann::json::array();
  for (const StudyDrive& drive : study.drives) names.push_back(name_of(study, drive));
  return {{"study", study.name}, {"description", study.description}, {"drives", names}};
}

nlohmann::json read_study(const std::string& folder) {
  const std::string file = folder + "/study.json";
  std::ifstream in{file};
  if (!in) fail(file, "no such file, or it is not readable; give the folder of a study");
  auto study = parse_json_or_null(in);
  const auto is_word = [](const nlohmann::json& value) { return value.is_string(); };
  const auto has = [&](const char* key) { return study.is_object() && study.contains(key); };
  if (has("study") && has("description") && has("drives") && study["description"].is_object() &&
      study["drives"].is_array() &&
      std::all_of(study["drives"].begin(), study["drives"].end(), is_word))
    return study;
  fail(file,
       "is damaged: it does not describe a study; if the study is unchanged, remove this file: "
       "`tandem study FILE --out " +
           folder + "` writes it again and keeps the finished drives");
}

void write_file(const std::string& file, const std::string& text) {
  const std::string part = file + ".part";
  const int out = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (out < 0) fail(file, std::strerror(errno));
  try {
    write_all(out, text, file);
  } catch (...) {
    close(out);
    throw;
  }
  const bool kept = fsync(out) == 0;
  close(out);
  if (!kept || rename(part.c_str(), file.c_str()) != 0) fail(file, std::strerror(errno));
}

}  // namespace tandem
