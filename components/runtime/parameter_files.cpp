// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameter_files.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

#include "tandem/config/yaml_document.hpp"

namespace tandem::runtime {
namespace {

constexpr const char* kParametersKey = "ros__parameters";

std::string place(const std::string& path, const YAML::Node& node) {
  return path + ":" + std::to_string(node.Mark().line + 1);
}

[[noreturn]] void fail(const std::string& path, const YAML::Node& node, const std::string& what) {
  throw std::invalid_argument(place(path, node) + ": " + what);
}

YAML::Node load(const std::string& path) {
  if (path.ends_with(".urdf"))
    throw std::invalid_argument(
        path + ": a URDF has no limits and delays; make a robot file of it: tandem robot " + path +
        " > robot.yaml");
  const YAML::Node root = load_document(path);
  if (!root.IsNull()) return root;
  // A truncated robot file would describe a different robot; a power loss can leave an empty file.
  throw std::invalid_argument("parameter file " + path +
                              " is empty; restore it, or remove it from the list");
}

// Adds the file's name to the YAML reader's errors.
template <class Read>
auto named(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(describe(path, error));
  }
}

// Collects the sections of one file that apply to one node.
class Collector {
 public:
  Collector(const std::string& path, const std::string& full_name)
      : path_{path}, full_name_{full_name} {}

  std::vector<FileSection> sections() {
    visit_names(load(path_), "");
    return std::move(sections_);
  }
  std::vector<FileValue> collect() {
    visit_names(load(path_), "");
    std::stable_partition(values_.begin(), values_.end(),
                          [](const FileValue& value) { return value.wildcard; });
    return std::move(values_);
  }

 private:
  // A map of node names, or of namespaces that hold such maps.
  void visit_names(const YAML::Node& node, const std::string& name) {
    if (!node.IsMap()) fail(path_, node, "expected `node: ros__parameters:`");
    for (const auto& entry : node) {
      const auto key = entry.first.as<std::string>();
      if (key == kParametersKey && !name.empty())
        sections_.push_back({name, place(path_, entry.first)});
      if (key != kParametersKey)
        visit_names(entry.second, name + (key.starts_with('/') ? "" : "/") + key);
      else if (name.empty())
        fail(path_, entry.first, "ros__parameters belongs under a node's name or /**");
      else if (matches_node(name, full_name_))
        visit_parameters(entry.second, name.find('*') != std::string::npos);
    }
  }

  void visit_parameters(const YAML::Node& node, bool wildcard) {
    if (node.IsNull()) return;
    if (!node.IsMap()) fail(path_, node, "ros__parameters must be a map of keys and values");
    std::set<std::string> seen;
    flatten(node, "", wildcard, seen);
  }

  void flatten(const YAML::Node& node, const std::string& prefix, bool wildcard,
               std::set<std::string>& seen) {
    for (const auto& entry : node) {
      const std::string key = prefix + entry.first.as<std::string>();
      if (entry.second.IsMap()) {
        flatten(entry.second, key + ".", wildcard, seen);
        continue;
      }
      if (!seen.insert(key).second) fail(path_, entry.first, key + " is given twice");
      values_.push_back({key, yaml_text(entry.second), place(path_, entry.first), wildcard});
    }
  }

  const std::string& path_;
  const std::string& full_name_;
  std::vector<FileValue> values_;
  std::vector<FileSection> sections_;
};

// Removes and returns the first token of "/a/b".
std::string_view take_token(std::string_view& name) {
  name.remove_prefix(1);
  const auto end = std::min(name.find('/'), name.size());
  const auto token = name.substr(0, end);
  name.remove_prefix(end);
  return token;
}

}  // namespace

bool matches_node(std::string_view pattern, std::string_view full_name) {
  if (pattern.empty()) return full_name.empty();
  auto rest = pattern;
  const auto token = take_token(rest);
  if (token == "**") {
    if (matches_node(rest, full_name)) return true;
    if (full_name.empty()) return false;
    take_token(full_name);
    return matches_node(pattern, full_name);
  }
  if (full_name.empty()) return false;
  const auto mine = take_token(full_name);
  return (token == "*" || token == mine) && matches_node(rest, full_name);
}

std::vector<FileValue> read_parameter_file(const std::string& path, const std::string& full_name) {
  return named(path, [&] { return Collector{path, full_name}.collect(); });
}

std::vector<FileSection> sections_for_nobody(const std::string& path,
                                             const std::vector<std::string>& full_names) {
  auto sections = named(path, [&] { return Collector{path, ""}.sections(); });
  std::erase_if(sections, [&](const FileSection& section) {
    return std::any_of(full_names.begin(), full_names.end(),
                       [&](const std::string& name) { return matches_node(section.name, name); });
  });
  return sections;
}

}  // namespace tandem::runtime
