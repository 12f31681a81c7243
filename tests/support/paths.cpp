// SPDX-License-Identifier: Apache-2.0
#include "support/paths.hpp"

#include <algorithm>
#include <filesystem>

namespace tandem::test {
namespace {

std::string within(const std::string& folder, const std::string& file) {
  return file.empty() ? folder : folder + "/" + file;
}

}  // namespace

std::string source_path(const std::string& file) { return within(TANDEM_SOURCE_DIR, file); }

std::vector<std::string> yaml_files(const std::string& folder, const std::string& prefix) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator{source_path(folder)})
    if (entry.path().extension() == ".yaml" && entry.path().filename().string().starts_with(prefix))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string binary_path(const std::string& file) { return within(TANDEM_BINARY_DIR, file); }
std::string shared_path(const std::string& file) { return within(TANDEM_SHARED_DIR, file); }
std::string peers_path(const std::string& file) { return within(TANDEM_PEERS_DIR, file); }

}  // namespace tandem::test
