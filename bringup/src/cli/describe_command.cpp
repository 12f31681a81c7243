// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/describe_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/system/component_params.hpp"
#include "bringup/system/component_topics.hpp"

namespace tandem {
namespace {

// Prints each field of a parameter struct as a row.
struct Printer {
  static void row(const char* name, const std::string& value, const std::string& bounds,
                  const char* meaning) {
    std::printf("  %-24s %-12s %-22s %s\n", name, value.c_str(), bounds.c_str(), meaning);
  }
  static std::string bounds(const Range& range) {
    return fmt::format("[{}, {}]", range.min, range.max);
  }

  void operator()(const char* name, double value, const Range& range, const char* meaning) const {
    row(name, fmt::format("{}", value), bounds(range), meaning);
  }
  void operator()(const char* name, int value, const Range& range, const char* meaning) const {
    row(name, fmt::format("{}", value), bounds(range), meaning);
  }
  void operator()(const char* name, const std::string& value, const OneOf& choices,
                  const char* meaning) const {
    row(name, value, fmt::format("{}", fmt::join(choices.names, " | ")), meaning);
  }
  void operator()(const char* name, const std::vector<double>& values, const Range& range,
                  const char* meaning) const {
    row(name, fmt::format("[{}]", fmt::join(values, ", ")), bounds(range), meaning);
  }
  void operator()(const char* name, const std::vector<std::string>& values, const OneOf& choices,
                  const char* meaning) const {
    row(name, fmt::format("[{}]", fmt::join(values, ", ")),
        fmt::format("each {}", fmt::join(choices.names, " | ")), meaning);
  }
  void operator()(const char* name, bool value, const char* meaning) const {
    row(name, value ? "true" : "false", "", meaning);
  }
  void operator()(const char* name, const std::string& value, const char* meaning) const {
    row(name, value.empty() ? "\"\"" : value, "", meaning);
  }
};

std::string list(std::vector<const char*> names, const char* other) {
  if (*other != '\0') names.push_back(other);
  return fmt::format("{}", fmt::join(names, ", "));
}

// Formats inputs and outputs as "a, b -> c; services d".
std::string summary(const ComponentTopics& topics) {
  std::string text = list(topics.subscribes, topics.other_input) + " -> " +
                     list(topics.publishes, topics.other_output);
  if (!topics.serves.empty()) text += "; services " + list(topics.serves, "");
  if (!topics.calls.empty()) text += "; calls services " + list(topics.calls, "");
  return text;
}

void print(const std::string& component) {
  std::string known;
  bool found = false;
  for_each_component([&](const char* name, auto params) {
    known += std::string{" "} + name;
    if (component != name) return;
    found = true;
    std::printf("%s: %s\n\n", name, summary(topics_of(name)).c_str());
    std::printf("  %-24s %-12s %-22s %s\n", "parameter", "default", "bounds", "meaning");
    params.visit(Printer{});
  });
  if (!found) throw std::invalid_argument("no component '" + component + "'; there are:" + known);
}

}  // namespace

void add_describe_command(CLI::App& app) {
  auto* command = app.add_subcommand("describe", "Topics and parameters of a component");
  auto component = std::make_shared<std::string>();
  command->add_option("component", *component, "its name; see `tandem list`")->required();
  command->callback([component] { print(*component); });
}

}  // namespace tandem
