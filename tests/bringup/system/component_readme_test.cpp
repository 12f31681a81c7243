// SPDX-License-Identifier: Apache-2.0
// Compares the table of topics in each component's README with what the component describes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "support/paths.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

using Names = std::set<std::string>;
using NamesByDirection = std::map<std::string, Names>;  // "subscribes", "serves", …

// The names in rows such as "| subscribes | `odom`, `/tf` | … |".
NamesByDirection names_in(const std::string& readme) {
  static const std::regex row{R"(\| (subscribes|publishes|serves|serves action) \| ([^|]*) \|.*)"};
  static const std::regex name{"`([^`]+)`"};
  NamesByDirection names{
      {"subscribes", {}}, {"publishes", {}}, {"serves", {}}, {"serves action", {}}};
  std::ifstream file{readme};
  std::smatch cells;
  for (std::string line; std::getline(file, line);) {
    if (!std::regex_match(line, cells, row)) continue;
    const std::string cell = cells[2];
    for (std::sregex_iterator it{cell.begin(), cell.end(), name}, end; it != end; ++it)
      names[cells[1]].insert((*it)[1]);
  }
  return names;
}

template <class Use>
Names names_of(const std::vector<Use>& uses) {
  Names names;
  for (const Use& use : uses)
    if (use.name != "*") names.insert(use.name);
  return names;
}

TEST(Readmes, ListTheTopicsThatTheComponentsDescribe) {
  int components = 0;
  for (const auto& component : rt::list_components()) {
    const auto readme = test::source_path("components/" + component + "/README.md");
    if (!std::filesystem::exists(readme)) continue;  // a component of the tests
    ++components;
    const rt::Interface interface = rt::description_of(component).interface;
    const NamesByDirection described{{"subscribes", names_of(interface.subscribes)},
                                     {"publishes", names_of(interface.publishes)},
                                     {"serves", names_of(interface.serves)},
                                     {"serves action", names_of(interface.serves_actions)}};
    EXPECT_EQ(names_in(readme), described) << readme;
  }
  EXPECT_GE(components, 14);
}

}  // namespace
}  // namespace tandem
