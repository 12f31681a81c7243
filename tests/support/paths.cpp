// SPDX-License-Identifier: Apache-2.0
#include "support/paths.hpp"

namespace tandem::test {
namespace {

std::string within(const std::string& folder, const std::string& file) {
  return file.empty() ? folder : folder + "/" + file;
}

}  // namespace

std::string source_path(const std::string& file) { return within(TANDEM_SOURCE_DIR, file); }
std::string binary_path(const std::string& file) { return within(TANDEM_BINARY_DIR, file); }
std::string shared_path(const std::string& file) { return within(TANDEM_SHARED_DIR, file); }
std::string peers_path(const std::string& file) { return within(TANDEM_PEERS_DIR, file); }

}  // namespace tandem::test
