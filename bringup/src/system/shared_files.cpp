// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/shared_files.hpp"

#include <set>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

fs::path folder_of(const std::string& kind) {
  return kind == "maps" ? share_folder() / kind : share_folder() / "bringup" / kind;
}

// The file of that name in Tandem's folder of the kind; empty if there is none. A map that has a
// description, too, is the OctoMap.
fs::path own_file(const std::string& name, const std::string& kind) {
  if (name.empty() || name.find('/') != std::string::npos) return {};
  for (const auto* suffix : {"", ".bt", ".yaml"})
    if (const auto file = folder_of(kind) / (name + suffix); is_file(file)) return file;
  return {};
}

// "no such file; did you mean `jackal`? Tandem's own robots are: …"
std::string missing(const std::string& name, const std::string& kind) {
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator{folder_of(kind), error})
    if (entry.path().extension() == ".yaml") names.insert(entry.path().stem());
  std::string all;
  for (const auto& own : names) all += (all.empty() ? "" : ", ") + own;
  const std::string nearest = nearest_name(fs::path{name}.stem().string(), names);
  return "no such file; " + (nearest.empty() ? "" : "did you mean `" + nearest + "`? ") +
         "Tandem's own " + kind + " are: " + all;
}

}  // namespace

fs::path share_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const auto& prefix : {program, program.parent_path()})
    if (const auto folder = prefix / "share" / "tandem"; fs::is_directory(folder, error))
      return folder;
  throw std::runtime_error("no folder share/tandem in " + program.string() + " or in " +
                           program.parent_path().string() + "; install or build Tandem again");
}

std::string find_file(const std::string& argument, const std::string& kind) {
  if (is_file(argument)) return argument;
  if (const auto file = own_file(argument, kind); !file.empty()) return file;
  throw std::invalid_argument(argument + ": " + missing(argument, kind));
}

std::string find_file(const YamlReader& value, const std::string& kind) {
  const std::string path = value.path();
  if (is_file(path)) return path;
  if (const auto file = own_file(value.as<std::string>(), kind); !file.empty()) return file;
  std::error_code error;
  if (fs::is_directory(path, error))
    value.fail(value.key() + ": " + path + " is a folder; name a file in it");
  value.fail(value.key() + ": " + path + ": " + missing(path, kind));
}

}  // namespace tandem
