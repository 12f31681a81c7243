// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr unsigned kMaxSeed = 1'000'000'000;

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

void write_all(int file, const std::string& text, const std::string& name) {
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t n = write(file, text.data() + written, text.size() - written);
    if (n < 0 && errno != EINTR) fail(name, std::strerror(errno));
    if (n > 0) written += static_cast<std::size_t>(n);
  }
}

// Throws if the folder holds the results of a Tandem that kept a line of JSON per drive.
void refuse_lines(const std::string& folder) {
  const std::string lines = folder + "/drives.jsonl";
  if (fs::exists(lines) && !fs::exists(folder + "/drives.sqlite"))
    fail(lines, "is of an older tandem, and this one cannot read it; choose another folder");
}

// Makes the folder that of the study, and returns the path of its results.
std::string claim(const std::string& folder, const json& study) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, error.message() + "; choose a folder that exists or can be created");
  refuse_lines(folder);
  const std::string file = folder + "/study.json";
  if (!fs::exists(file)) write_file(file, study.dump(1) + "\n");
  const json kept = read_study(folder);
  if (kept != study)
    throw std::invalid_argument(folder + ": contains another study (" +
                                first_difference(kept.at("description"), study.at("description")) +
                                " differs); choose another folder, or remove this one");
  return folder + "/drives.sqlite";
}

json json_of(const DriveGroup& group, const std::vector<unsigned>& seeds) {
  return {{"scenario", group.scenario},
          {"method", group.method},
          {"driver", group.driver},
          {"seeds", seed_ranges(seeds)}};
}

// Throws nlohmann::json::exception or std::invalid_argument.
PlannedGroup group_of(const json& group) {
  return {{group.at("scenario"), group.at("method"), group.at("driver")},
          seeds_in(group.at("seeds").get<std::string>())};
}

std::vector<PlannedGroup> groups_of(const json& study) {
  std::vector<PlannedGroup> groups;
  for (const json& group : study.at("groups")) groups.push_back(group_of(group));
  return groups;
}

bool describes_a_study(const json& study) {
  try {
    (void)groups_of(study);
    return study.at("study").is_string() && study.at("description").is_object() &&
           study.at("groups").is_array();
  } catch (const std::exception&) {
    return false;
  }
}

unsigned number(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > kMaxSeed)
    throw std::invalid_argument(fmt::format("`{}` is not a seed", text));
  return value;
}

}  // namespace

StudyFolder::StudyFolder(const std::string& folder, const json& study)
    : folder_{folder}, groups_{groups_of(study)}, results_{claim(folder, study)} {}

std::size_t StudyFolder::planned() const {
  return std::accumulate(
      groups_.begin(), groups_.end(), std::size_t{0},
      [](std::size_t sum, const PlannedGroup& group) { return sum + group.seeds.size(); });
}

DriveGroup group_of(const Study& study, const StudyDrive& drive) {
  const StudyCell& cell = study.cells[drive.cell];
  return {cell.scenario.name, cell.method, cell.driver};
}

json contents_of(const Study& study) {
  std::vector<DriveGroup> order;
  std::map<DriveGroup, std::vector<unsigned>> seeds;
  std::size_t cell = study.cells.size();
  DriveGroup group;
  for (const StudyDrive& drive : study.drives) {
    if (drive.cell != cell) group = group_of(study, drive);
    cell = drive.cell;
    const auto [own, is_new] = seeds.try_emplace(group);
    if (is_new) order.push_back(group);
    own->second.push_back(drive.seed);
  }
  json groups = json::array();
  for (const DriveGroup& each : order) {
    std::sort(seeds[each].begin(), seeds[each].end());
    groups.push_back(json_of(each, seeds[each]));
  }
  return {{"study", study.name}, {"description", study.description}, {"groups", groups}};
}

json read_study(const std::string& folder) {
  refuse_lines(folder);
  const std::string file = folder + "/study.json";
  std::ifstream in{file};
  if (!in) fail(file, "no such file, or it is not readable; give the folder of a study");
  auto study = parse_json_or_null(in);
  if (describes_a_study(study)) return study;
  fail(file,
       "is damaged: it does not describe a study; if the study is unchanged, remove this file: "
       "`tandem study FILE --out " +
           folder + "` writes it again and keeps the finished drives");
}

// The name is compared first, because the files of another study differ too.
std::string first_difference(const json& kept, const json& asked) {
  if (kept.value("study", json{}) != asked.value("study", json{})) return "study";
  for (const auto& [key, value] : asked.items())
    if (!kept.contains(key) || kept.at(key) != value) return key;
  return "its list of files";
}

std::string seed_ranges(const std::vector<unsigned>& seeds) {
  std::string text;
  for (std::size_t first = 0, last = 0; first < seeds.size(); first = ++last) {
    while (last + 1 < seeds.size() && seeds[last + 1] == seeds[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(seeds[first]);
    if (last > first) text += "-" + std::to_string(seeds[last]);
  }
  return text;
}

std::vector<unsigned> seeds_in(const std::string& ranges) {
  std::vector<unsigned> seeds;
  for (std::string_view rest = ranges; !rest.empty();) {
    const std::string_view range = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), range.size() + 1));
    const auto dash = range.find('-');
    const unsigned first = number(range.substr(0, dash));
    const unsigned last = dash == range.npos ? first : number(range.substr(dash + 1));
    if (last < first)
      throw std::invalid_argument(fmt::format("`{}` is not a range of seeds", range));
    for (unsigned seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  return seeds;
}

// The temporary file has a random name, because several workers may write the same file at once.
void write_file(const std::string& file, const std::string& text) {
  std::string part = file + ".XXXXXX";
  const int out = mkostemp(part.data(), O_CLOEXEC);
  if (out < 0) fail(file, std::strerror(errno));
  try {
    write_all(out, text, file);
  } catch (...) {
    close(out);
    unlink(part.c_str());
    throw;
  }
  const bool kept = fchmod(out, 0644) == 0 && fsync(out) == 0;
  close(out);
  if (kept && rename(part.c_str(), file.c_str()) == 0) return;
  const int error = errno;
  unlink(part.c_str());
  fail(file, std::strerror(error));
}

}  // namespace tandem
