// SPDX-License-Identifier: Apache-2.0
#include "runtime/parameters.hpp"

#include <mutex>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

#include "runtime/parameter_files.hpp"

namespace tandem::runtime {
namespace {

// Keys of wildcard sections → whether some node of this process declared them.
struct Wildcards {
  std::mutex mutex;
  std::map<std::string, bool> used;
};

Wildcards& wildcards() {
  static Wildcards all;
  return all;
}

void note_wildcard(const std::string& origin, const std::string& key, bool used) {
  const std::lock_guard lock{wildcards().mutex};
  auto& entry = wildcards().used[origin + ": " + key];
  entry = entry || used;
}

bool is_quoted(const YAML::Node& node) { return node.Tag() == "!"; }

template <class T>
bool reads_as(const YAML::Node& node, T& value) {
  if (!node.IsScalar() || is_quoted(node)) return false;
  return YAML::convert<T>::decode(node, value);
}

bool reads_as(const YAML::Node& node, std::string& value) {
  double number = 0.0;
  bool truth = false;
  if (!node.IsScalar() || reads_as(node, number) || reads_as(node, truth)) return false;
  value = node.Scalar();
  return true;
}

bool reads_as(const YAML::Node& node, std::vector<double>& values) {
  if (!node.IsSequence()) return false;
  values.assign(node.size(), 0.0);
  for (std::size_t i = 0; i < node.size(); ++i)
    if (!reads_as(node[i], values[i])) return false;
  return true;
}

constexpr const char* kind(const double&) { return "a number"; }
constexpr const char* kind(const int&) { return "an integer"; }
constexpr const char* kind(const bool&) { return "true or false"; }
const char* kind(const std::string&) { return "text (a number as text needs quotes)"; }
const char* kind(const std::vector<double>&) { return "a list of numbers"; }

}  // namespace

struct ParameterStore::State {
  struct Given {
    ParameterValue value;
    bool wildcard;
    bool declared = false;
  };

  void add_file(const std::string& path) {
    for (auto& found : read_parameter_file(path, node)) {
      if (found.wildcard) note_wildcard(found.origin, found.key, false);
      given[found.key] = {{std::move(found.yaml), std::move(found.origin)}, found.wildcard};
    }
  }

  void add_values(const std::map<std::string, ParameterValue>& values) {
    for (const auto& [key, value] : values) given[key] = {value, false};
  }

  [[noreturn]] void fail(const Given& entry, const std::string& what) const {
    throw std::invalid_argument(entry.value.origin + ": node " + node + ": " + what);
  }

  // Loads one field, if it is given, and checks it; `limits` are what Checker wants to know.
  template <class T, class... Limits>
  void load(const char* name, T& value, const Limits&... limits) {
    const auto found = given.find(name);
    if (found == given.end()) return Checker{}(name, value, limits...);
    Given& entry = found->second;
    entry.declared = true;
    if (entry.wildcard) note_wildcard(entry.value.origin, name, true);
    if (!read(entry.value.yaml, value))
      fail(entry, std::string{name} + " = " + entry.value.yaml + " is not " + kind(value));
    try {
      Checker{}(name, value, limits...);
    } catch (const std::invalid_argument& error) {
      fail(entry, error.what());
    }
  }

  template <class T>
  static bool read(const std::string& yaml, T& value) {
    try {
      return reads_as(YAML::Load(yaml), value);
    } catch (const YAML::Exception&) {
      return false;
    }
  }

  std::string node;
  std::map<std::string, Given> given;
};

ParameterStore::ParameterStore(std::string fully_qualified_name, const ParameterSources& sources)
    : state_{std::make_unique<State>()} {
  state_->node = std::move(fully_qualified_name);
  for (const auto& file : sources.files) state_->add_file(file);
  state_->add_values(sources.values);
  for (const auto& file : sources.override_files) state_->add_file(file);
  state_->add_values(sources.overrides);
}

ParameterStore::~ParameterStore() = default;
ParameterStore::ParameterStore(ParameterStore&&) noexcept = default;
ParameterStore& ParameterStore::operator=(ParameterStore&&) noexcept = default;

void ParameterStore::operator()(const char* name, double& value, const Range& range,
                                const char* meaning) {
  state_->load(name, value, range, meaning);
}
void ParameterStore::operator()(const char* name, int& value, const Range& range,
                                const char* meaning) {
  state_->load(name, value, range, meaning);
}
void ParameterStore::operator()(const char* name, std::string& value, const OneOf& choices,
                                const char* meaning) {
  state_->load(name, value, choices, meaning);
}
void ParameterStore::operator()(const char* name, std::vector<double>& values, const Range& range,
                                const char* meaning) {
  state_->load(name, values, range, meaning);
}
void ParameterStore::operator()(const char* name, bool& value, const char* meaning) {
  state_->load(name, value, meaning);
}
void ParameterStore::operator()(const char* name, std::string& value, const char* meaning) {
  state_->load(name, value, meaning);
}

void ParameterStore::check_unknown() const {
  for (const auto& [key, entry] : state_->given)
    if (!entry.declared && !entry.wildcard)
      state_->fail(entry, key + " = " + entry.value.yaml + " is no parameter of this node");
}

std::vector<std::string> unused_wildcard_keys() {
  const std::lock_guard lock{wildcards().mutex};
  std::vector<std::string> unused;
  for (const auto& [key, used] : wildcards().used)
    if (!used) unused.push_back(key);
  return unused;
}

}  // namespace tandem::runtime
