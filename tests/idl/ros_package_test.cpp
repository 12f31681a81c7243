// SPDX-License-Identifier: Apache-2.0
// Checks that the ROS 2 package idl/tandem_msgs/ and idl/tandem_msgs.idl define the same types.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// The fields by type name ("Obstacle", "SetPolicy_Request"), one line "type name" per field.
using Structures = std::map<std::string, std::string>;

const fs::path kFolder = test::source_path("idl");

std::string text_of(const fs::path& path) {
  std::ifstream in{path};
  EXPECT_TRUE(in.good()) << path;
  return {std::istreambuf_iterator<char>{in}, {}};
}

std::string ros_type(const std::string& type) {
  static const std::map<std::string, std::string> basic{
      {"double", "float64"}, {"float", "float32"}, {"boolean", "bool"}, {"octet", "byte"}};
  std::smatch part;
  if (std::regex_match(type, part, std::regex{"sequence<(.+)>"})) return ros_type(part[1]) + "[]";
  if (std::regex_match(type, part, std::regex{"(\\w+)::msg::(\\w+)"}))
    return part[1].str() + "/" + part[2].str();
  const auto found = basic.find(type);
  return found == basic.end() ? type : found->second;
}

Structures from_idl() {
  const std::string text =
      std::regex_replace(text_of(kFolder / "tandem_msgs.idl"), std::regex{"//[^\n]*"}, "");
  Structures all;
  const std::regex structure{"struct (\\w+) \\{([^}]*)\\}"}, field{"(\\S+) (\\w+);"};
  for (std::sregex_iterator s{text.begin(), text.end(), structure}, end; s != end; ++s) {
    const std::string body = (*s)[2];
    std::string& fields = all[(*s)[1]];
    for (std::sregex_iterator f{body.begin(), body.end(), field}; f != end; ++f)
      fields += ros_type((*f)[1]) + " " + (*f)[2].str() + "\n";
  }
  return all;
}

// Without comments and empty lines.
std::string bare(const std::string& text) {
  std::istringstream in{text};
  std::string out;
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] != '#') out += line + "\n";
  return out;
}

Structures from_package() {
  Structures all;
  for (const auto& entry : fs::directory_iterator{kFolder / "tandem_msgs" / "msg"})
    all[entry.path().stem().string()] = bare(text_of(entry.path()));
  for (const auto& entry : fs::directory_iterator{kFolder / "tandem_msgs" / "srv"}) {
    const std::string text = bare(text_of(entry.path())), name = entry.path().stem().string();
    const auto line = text.find("---\n");
    all[name + "_Request"] = text.substr(0, line);
    all[name + "_Response"] = text.substr(line + 4);
  }
  return all;
}

TEST(RosPackage, MatchesTheIdl) {
  const Structures idl = from_idl();
  ASSERT_GE(idl.size(), 8U);
  EXPECT_EQ(from_package(), idl);
}

TEST(RosPackage, GeneratesEveryFileItHas) {
  const std::string cmake = text_of(kFolder / "tandem_msgs" / "CMakeLists.txt");
  for (const char* kind : {"msg", "srv"})
    for (const auto& entry : fs::directory_iterator{kFolder / "tandem_msgs" / kind})
      EXPECT_NE(cmake.find(std::string{kind} + "/" + entry.path().filename().string()),
                std::string::npos)
          << entry.path();
}

}  // namespace
}  // namespace tandem
