// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/arguments.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "tandem/runtime/dds_security.hpp"

namespace tandem::runtime {
namespace {

struct Rule {
  std::string node, from, to;
};

// "a:=b" or "node:a:=b".
Rule parse_rule(const std::string& text) {
  const auto assign = text.find(":=");
  if (assign == std::string::npos || assign == 0)
    throw std::invalid_argument("--ros-args: '" + text + "' is not of the form name:=value");
  const std::string left = text.substr(0, assign);
  const auto colon = left.find(':');
  if (colon == std::string::npos) return {"", left, text.substr(assign + 2)};
  return {left.substr(0, colon), left.substr(colon + 1), text.substr(assign + 2)};
}

void apply_remapping(NodeOptions& options, const std::string& from, const std::string& to) {
  if (from == "__node" || from == "__name")
    options.name = to;
  else if (from == "__ns")
    options.ns = to;
  else
    options.remappings[from] = to;
}

// "ns.name": ROS 2's logger name for a node.
std::string logger_name_of(const NodeOptions& options) {
  std::string name = options.ns + "/" + options.name;
  std::replace(name.begin(), name.end(), '/', '.');
  return name.substr(name.find_first_not_of('.'));
}

class Parser {
 public:
  explicit Parser(const std::vector<std::string>& arguments) : arguments_{arguments} {}

  RosArguments parse() {
    bool ours = false;
    for (; at_ < arguments_.size(); ++at_) {
      const std::string& word = arguments_[at_];
      if (word == "--ros-args")
        ours = true;
      else if (ours && word == "--")
        ours = false;
      else if (ours)
        parse_one(word);
      else
        result_.rest.push_back(word);
    }
    return std::move(result_);
  }

 private:
  void parse_one(const std::string& word) {
    if (word == "-r" || word == "--remap") {
      const Rule rule = parse_rule(value_of(word));
      result_.remappings[rule.node][rule.from] = rule.to;
    } else if (word == "-p" || word == "--param") {
      const Rule rule = parse_rule(value_of(word));
      result_.parameters[rule.node][rule.from] = rule.to;
    } else if (word == "--params-file") {
      result_.parameter_files.push_back(value_of(word));
    } else if (word == "--log-level") {
      set_level(value_of(word));
    } else if (word.ends_with("-logs") &&
               (word.starts_with("--enable-") || word.starts_with("--disable-"))) {
      switch_logs(word);
    } else if (word == "-e" || word == "--enclave") {
      set_enclave(value_of(word));
    } else if (word == "--log-config-file") {
      (void)value_of(word);  // configures rcl's logging library: ignored
    } else if (word.find(":=") != std::string::npos && word.starts_with("__")) {
      const Rule rule = parse_rule(word);
      result_.remappings[rule.node][rule.from] = rule.to;
    } else {
      throw std::invalid_argument("--ros-args: unknown argument '" + word + "'");
    }
  }

  // "debug", or "node:=debug".
  void set_level(const std::string& text) {
    const auto assign = text.find(":=");
    if (assign == std::string::npos) return set_log_level(log_level_from(text));
    result_.log_levels[text.substr(0, assign)] = log_level_from(text.substr(assign + 2));
  }

  // Handles "--disable-rosout-logs" and the like; switches for external libraries have no effect.
  void switch_logs(const std::string& word) {
    const bool on = word.starts_with("--enable-");
    const std::string what = word.substr(on ? 9 : 10);
    if (what == "rosout-logs")
      result_.rosout = on;
    else if (what == "stdout-logs")
      set_log_to_stderr(on);
    else if (what != "external-lib-logs")
      throw std::invalid_argument("--ros-args: unknown argument '" + word + "'");
  }

  const std::string& value_of(const std::string& word) {
    if (++at_ >= arguments_.size())
      throw std::invalid_argument("--ros-args: " + word + " needs a value");
    return arguments_[at_];
  }

  const std::vector<std::string>& arguments_;
  std::size_t at_ = 0;
  RosArguments result_;
};

}  // namespace

RosArguments parse_ros_arguments(const std::vector<std::string>& arguments) {
  return Parser{arguments}.parse();
}

std::vector<std::string> strangers_in(const RosArguments& arguments,
                                      const std::vector<NodeOptions>& nodes) {
  std::set<std::string> before{""}, after{""}, strangers;
  for (const auto& node : nodes) {
    before.insert(node.name);
    after.insert(with_arguments(node, arguments).name);
  }
  for (const auto& [node, rules] : arguments.remappings)
    if (!before.contains(node)) strangers.insert(node);
  for (const auto& [node, values] : arguments.parameters)
    if (!before.contains(node) && !after.contains(node)) strangers.insert(node);
  return {strangers.begin(), strangers.end()};
}

NodeOptions with_arguments(NodeOptions options, const RosArguments& arguments) {
  const std::string name = options.name;
  for (const auto& [node, rules] : arguments.remappings)
    if (node.empty() || node == name)
      for (const auto& [from, to] : rules) apply_remapping(options, from, to);
  for (const auto& [node, values] : arguments.parameters)
    if (node.empty() || node == name || node == options.name)
      for (const auto& [key, value] : values)
        options.parameters.overrides[key] = {value, "command line", node.empty()};
  options.logs_to_rosout = options.logs_to_rosout && arguments.rosout;
  for (const auto& [logger, level] : arguments.log_levels)
    if (logger == options.name || logger == logger_name_of(options)) options.log_level = level;
  for (const auto& file : arguments.parameter_files)
    options.parameters.override_files.push_back(file);
  return options;
}

}  // namespace tandem::runtime
