// SPDX-License-Identifier: Apache-2.0
#include "tandem/joystick/joystick_devices.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace tandem {
namespace {

namespace fs = std::filesystem;

// The kernel prints the set of absolute axes as hexadecimal words, "0" if it is empty.
bool has_axes(const fs::path& device) {
  std::ifstream file{device / "device/capabilities/abs"};
  std::string words;
  std::getline(file, words);
  return words.find_first_not_of("0 ") != std::string::npos;
}

}  // namespace

bool may_have_joystick(const std::string& input_class) {
  std::error_code missing;
  const fs::directory_iterator devices{input_class, missing};
  return std::any_of(begin(devices), end(devices),
                     [](const auto& device) { return has_axes(device.path()); });
}

}  // namespace tandem
