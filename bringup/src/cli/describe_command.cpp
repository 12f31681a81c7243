// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/describe_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "tandem/runtime/component.hpp"
#include "tandem/runtime/every_node.hpp"

namespace tandem {
namespace {

constexpr std::size_t kColumns = 4;
using Row = std::array<std::string, kColumns>;

// Prints a table with a head, columns aligned; nothing if there are no rows.
void print_table(const Row& head, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  std::array<std::size_t, kColumns> widths{};
  const auto widen = [&](const Row& row) {
    for (std::size_t i = 0; i < kColumns; ++i) widths[i] = std::max(widths[i], row[i].size());
  };
  const auto print = [&](const Row& row) {
    std::string line = " ";
    for (std::size_t i = 0; i < kColumns; ++i) line += fmt::format(" {:<{}}", row[i], widths[i]);
    std::printf("%s\n", line.substr(0, line.find_last_not_of(' ') + 1).c_str());
  };
  widen(head);
  std::for_each(rows.begin(), rows.end(), widen);
  std::printf("\n");
  print(head);
  std::for_each(rows.begin(), rows.end(), print);
}

std::string in_words(const std::string& condition) {
  return condition.empty() ? "" : "if " + condition;
}

Row row_of(const rt::TopicUse& use) {
  if (use.name == rt::TopicUse::every().name) return {"every topic", "", "", ""};
  return {use.name, use.type, to_text(use.qos), in_words(use.condition)};
}

Row row_of_subscription(const rt::TopicUse& use) {
  Row row = row_of(use);
  if (use.accepts == rt::Accepts::kEvery && !use.type.empty()) row[2] += ", or weaker";
  return row;
}

Row row_of(const rt::ServiceUse& use) {
  if (use.name == rt::ServiceUse::every().name) return {"every service", "", "", ""};
  return {use.name, use.type, to_text(use.qos), in_words(use.condition)};
}

Row row_of(const rt::ActionUse& use) { return {use.name, use.type, "", in_words(use.condition)}; }

std::string bounds_of(const rt::Field& field) {
  struct {
    std::string operator()(std::monostate) const { return ""; }
    std::string operator()(const Range& range) const {
      return fmt::format("[{}, {}]", range.min, range.max);
    }
    std::string operator()(const OneOf& choices) const {
      return fmt::format("{}", fmt::join(choices.names, " | "));
    }
  } text;
  const bool is_list = std::holds_alternative<std::vector<double>*>(field.value) ||
                       std::holds_alternative<std::vector<std::string>*>(field.value);
  return (is_list ? "each " : "") + std::visit(text, field.limits);
}

Row row_of(const rt::Field& field) {
  return {field.name, rt::to_text(value_of(field)), bounds_of(field), field.meaning};
}

template <class T>
std::vector<Row> rows_of(const std::vector<T>& entries, Row (*to_row)(const T&) = row_of) {
  std::vector<Row> rows;
  for (const T& entry : entries) rows.push_back(to_row(entry));
  return rows;
}

void print(const std::string& name) {
  const rt::ComponentDescription component = rt::description_of(name);
  const rt::Interface& all = component.interface;
  std::printf("%s\n", name.c_str());
  print_table({"subscribes", "type", "QoS", ""}, rows_of(all.subscribes, row_of_subscription));
  print_table({"publishes", "type", "QoS", ""}, rows_of(all.publishes));
  print_table({"serves", "type", "QoS", ""}, rows_of(all.serves));
  print_table({"calls", "type", "QoS", ""}, rows_of(all.calls));
  print_table({"serves action", "type", "", ""}, rows_of(all.serves_actions));
  print_table({"calls action", "type", "", ""}, rows_of(all.calls_actions));
  if (!all.other_input.empty()) std::printf("\n  reads %s\n", all.other_input.c_str());
  if (!all.other_output.empty()) std::printf("\n  writes %s\n", all.other_output.c_str());
  print_table({"parameter", "default", "bounds", "meaning"}, rows_of(component.parameters));
  rt::every_node::Params common;
  print_table({"parameter of every node", "default", "bounds", "meaning"},
              rows_of(rt::fields_of(common)));
}

}  // namespace

void add_describe_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "describe",
      "Topics, services and actions of a component with type and QoS, and its parameters");
  auto component = std::make_shared<std::string>();
  command->add_option("component", *component, "its name; see `tandem list`")->required();
  command->callback([component] { print(*component); });
}

}  // namespace tandem
