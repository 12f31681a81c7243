// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/parameter_names.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

using Names = std::set<std::string>;

// A module that cannot be loaded has none; `tandem describe` and `tandem run` report why.
Names described_names(const std::string& component) {
  Names names;
  try {
    for (const auto& field : rt::description_of(component).parameters) names.insert(field.name);
  } catch (const std::invalid_argument&) {
  }
  return names;
}

// The parameters' names of the components that have been looked at.
class NamesByComponent {
 public:
  bool contain(const std::string& name) {
    const std::lock_guard lock{mutex_};
    const auto has_it = [&](const auto& entry) { return entry.second.contains(name); };
    if (std::any_of(names_.begin(), names_.end(), has_it)) return true;
    const auto all = rt::list_components();
    return std::any_of(all.begin(), all.end(),
                       [&](const std::string& component) { return of(component).contains(name); });
  }

  Names all() {
    const std::lock_guard lock{mutex_};
    Names names;
    for (const auto& component : rt::list_components())
      names.insert(of(component).begin(), of(component).end());
    return names;
  }

 private:
  const Names& of(const std::string& component) {
    const auto found = names_.find(component);
    if (found != names_.end()) return found->second;
    return names_.emplace(component, described_names(component)).first->second;
  }

  std::mutex mutex_;
  std::map<std::string, Names> names_;
};

NamesByComponent& names_by_component() {
  static NamesByComponent all;
  return all;
}

}  // namespace

bool is_parameter(const std::string& name) {
  return rt::is_parameter_of_every_node(name) || names_by_component().contain(name);
}

std::string nearest_parameter(const std::string& word) {
  return did_you_mean(word, names_by_component().all());
}

}  // namespace tandem
