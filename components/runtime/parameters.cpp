// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameters.hpp"

#include <mutex>
#include <set>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"
#include "tandem/runtime/parameter_files.hpp"

namespace tandem::runtime {
namespace {

// Keys of wildcard sections → whether any node of this process declared them.
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

}  // namespace

struct ParameterStore::State {
  struct Given {
    ParameterValue value;
    bool declared = false;
  };

  void add_file(const std::string& path) {
    for (auto& found : read_parameter_file(path, node))
      add(found.key, {std::move(found.yaml), std::move(found.origin), found.wildcard});
  }

  void add_values(const std::map<std::string, ParameterValue>& values) {
    for (const auto& [key, value] : values) add(key, value);
  }

  void add(const std::string& key, ParameterValue value) {
    if (value.for_all) note_wildcard(value.origin, key, false);
    const auto [entry, is_new] = given.try_emplace(key, Given{value});
    if (is_new) return;
    const ParameterValue& before = entry->second.value;  // overridden, but it still counts as used
    if (before.for_all) note_wildcard(before.origin, key, true);
    entry->second = {std::move(value)};
  }

  [[noreturn]] void fail(const Given& entry, const std::string& what) const {
    throw std::invalid_argument(entry.value.origin + ": node " + node + ": " + what);
  }

  std::string node;
  std::map<std::string, Given> given;
  std::set<std::string> declared;
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

void ParameterStore::load(const Field& field) {
  state_->declared.insert(field.name);
  const auto found = state_->given.find(field.name);
  if (found == state_->given.end()) return check(field);
  State::Given& entry = found->second;
  entry.declared = true;
  if (entry.value.for_all) note_wildcard(entry.value.origin, field.name, true);
  try {
    assign(field, value_from_yaml(entry.value.yaml));
    check(field);
  } catch (const std::invalid_argument& error) {
    state_->fail(entry, error.what());
  }
}

bool ParameterStore::gives_any(const std::string& prefix) const {
  const auto first = state_->given.lower_bound(prefix);
  return first != state_->given.end() && first->first.starts_with(prefix);
}

void ParameterStore::accept_all(const std::string& prefix) {
  for (auto entry = state_->given.lower_bound(prefix);
       entry != state_->given.end() && entry->first.starts_with(prefix); ++entry)
    entry->second.declared = true;
}

void ParameterStore::check_unknown() const {
  check_retired();
  for (const auto& [key, entry] : state_->given)
    if (!entry.declared && !entry.value.for_all)
      state_->fail(entry, key + " = " + entry.value.yaml + " is not a parameter of this node" +
                              did_you_mean(key, state_->declared));
}

void ParameterStore::check_retired() const {
  for (const auto& [key, entry] : state_->given)
    if (const char* instead = instead_of(key); instead && !entry.declared)
      state_->fail(entry, key + " = " + entry.value.yaml + ": this name was ambiguous; " + instead);
}

std::vector<std::string> unused_wildcard_keys() {
  const std::lock_guard lock{wildcards().mutex};
  std::vector<std::string> unused;
  for (const auto& [key, used] : wildcards().used)
    if (!used) unused.push_back(key);
  return unused;
}

}  // namespace tandem::runtime
