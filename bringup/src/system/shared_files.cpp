// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/shared_files.hpp"

#include <set>
#include <stdexcept>

namespace tandem {
namespace {

namespace fs = std::filesystem;

std::string names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator{folder, missing})
    if (entry.path().extension() == ".yaml") names.insert(entry.path().stem());
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
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
  std::error_code error;
  if (fs::is_regular_file(argument, error)) return argument;
  const bool is_name = argument.find('/') == std::string::npos;
  const fs::path folder = share_folder() / "bringup" / kind;
  for (const auto* suffix : {"", ".yaml"})
    if (const auto file = folder / (argument + suffix); is_name && fs::is_regular_file(file, error))
      return file;
  throw std::invalid_argument(argument + ": no such file; Tandem's own " + kind +
                              " are: " + names_in(folder));
}

}  // namespace tandem
