// SPDX-License-Identifier: Apache-2.0
// Checks that the ROS 2 package idl/tandem_msgs/ builds every message and service that it has. Its
// files are compared with the IDL by idl/generate_messages --check.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

TEST(RosPackage, GeneratesEveryFileItHas) {
  const fs::path package = test::source_path("idl/tandem_msgs");
  std::ifstream in{package / "CMakeLists.txt"};
  const std::string cmake{std::istreambuf_iterator<char>{in}, {}};
  for (const char* kind : {"msg", "srv"})
    for (const auto& entry : fs::directory_iterator{package / kind})
      EXPECT_NE(cmake.find(std::string{kind} + "/" + entry.path().filename().string() + "\n"),
                std::string::npos)
          << entry.path();
}

}  // namespace
}  // namespace tandem
