// SPDX-License-Identifier: Apache-2.0
// `tandem describe` prints every parameter, topic, service and action of each component that
// `tandem list` prints.
#include <gtest/gtest.h>

#include <cstdio>
#include <iterator>
#include <memory>
#include <set>
#include <sstream>
#include <string>

#include "tandem/runtime/component.hpp"

namespace tandem::test {
namespace {

using Names = std::set<std::string>;

// The words that a command prints; punctuation ends a word. Fails if the command does.
Names words_of(const std::string& command) {
  const auto close = [](FILE* pipe) { EXPECT_EQ(pclose(pipe), 0); };
  const std::unique_ptr<FILE, decltype(close)> pipe{popen(command.c_str(), "r"), close};
  std::string text;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get()))
    text += c == ',' || c == ';' || c == ':' ? ' ' : static_cast<char>(c);
  std::istringstream words{text};
  return {std::istream_iterator<std::string>{words}, {}};
}

Names described(const std::string& component) {
  const rt::ComponentDescription description = rt::description_of(component);
  const rt::Interface& interface = description.interface;
  Names names;
  for (const auto& parameter : description.parameters) names.insert(parameter.name);
  for (const auto* topics : {&interface.subscribes, &interface.publishes})
    for (const auto& topic : *topics) names.insert(topic.name);
  for (const auto* services : {&interface.serves, &interface.calls})
    for (const auto& service : *services) names.insert(service.name);
  for (const auto* actions : {&interface.serves_actions, &interface.calls_actions})
    for (const auto& action : *actions) names.insert(action.name);
  return names;
}

TEST(Describe, PrintsEveryParameterTopicAndServiceOfEachComponentThatListPrints) {
  const Names components = words_of("../tandem list");
  EXPECT_GE(components.size(), 14U);
  for (const std::string& component : components) {
    const Names printed = words_of("../tandem describe " + component);
    for (const std::string& name : described(component))
      EXPECT_TRUE(name == "*" || printed.contains(name)) << component << " " << name;
  }
}

}  // namespace
}  // namespace tandem::test
