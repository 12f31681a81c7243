// SPDX-License-Identifier: Apache-2.0
// `tandem describe` prints every parameter, topic and service of each component that `tandem list`
// prints.
#include <gtest/gtest.h>

#include <cstdio>
#include <iterator>
#include <memory>
#include <set>
#include <sstream>
#include <string>

#include "bringup/system/component_params.hpp"
#include "bringup/system/component_topics.hpp"

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

// Collects the names of the parameters that it visits.
struct NameOf {
  template <class... Rest>
  void operator()(const char* name, const Rest&...) const {
    names->insert(name);
  }
  Names* names;
};

Names topics_and_services_of(const std::string& component) {
  Names names;
  const ComponentTopics& topics = topics_of(component);
  for (const auto* list : {&topics.subscribes, &topics.publishes, &topics.serves, &topics.calls})
    names.insert(list->begin(), list->end());
  return names;
}

TEST(Describe, KnowsEachComponentThatListPrints) {
  Names known;
  for_each_component([&](const char* name, const auto&) { known.insert(name); });
  EXPECT_EQ(words_of("../tandem list"), known);
}

TEST(Describe, PrintsEveryParameterTopicAndServiceOfAComponent) {
  for_each_component([](const char* component, auto params) {
    const Names printed = words_of(std::string{"../tandem describe "} + component);
    Names names = topics_and_services_of(component);
    params.visit(NameOf{&names});
    for (const std::string& name : names)
      EXPECT_TRUE(printed.contains(name)) << component << " " << name;
  });
}

}  // namespace
}  // namespace tandem::test
