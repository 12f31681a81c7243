// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/component.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"
#include "tandem/config/printable.hpp"
#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/detail/module_file.hpp"
#include "tandem/runtime/detail/module_folders.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node_thread.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kModulePrefix = "libtandem_";
constexpr std::string_view kSuffix = ".so";
constexpr const char* kQosOverrides = "qos_overrides.";

struct Registry {
  std::mutex mutex;
  std::map<std::string, Component> components;
};

Registry& registry() {
  static Registry all;
  return all;
}

std::optional<Component> find_registered(const std::string& name) {
  const std::lock_guard lock{registry().mutex};
  const auto found = registry().components.find(name);
  if (found == registry().components.end()) return std::nullopt;
  return found->second;
}

fs::path file_of(const std::string& component) {
  return std::string{kModulePrefix} + component + std::string{kSuffix};
}

std::vector<std::string> find_folders() {
  std::vector<std::string> folders;
  if (const char* path = std::getenv("TANDEM_COMPONENT_PATH")) {
    std::istringstream stream{path};
    for (std::string folder; std::getline(stream, folder, ':');)
      if (!folder.empty()) folders.push_back(fs::absolute(folder));
  }
  for (const auto& folder : own_module_folders()) folders.push_back(folder);
  // A component that is built beside Debian's packages goes to /usr/local unless told otherwise.
  if (runtime_file().string().starts_with("/usr/lib/")) folders.push_back("/usr/local/lib/tandem");
  return folders;
}

// Why the module's code must not run in this process; empty if it may.
std::string obstacle_to(const std::optional<ModuleInfo>& module, const std::string& component) {
  if (!module)
    return "is not a module of Tandem " TANDEM_ABI_VERSION
           " (it does not contain TANDEM_COMPONENT, or was built for an older Tandem or another "
           "machine); rebuild it against this Tandem";
  if (module->abi != TANDEM_ABI_VERSION)
    return "was built for Tandem " + printable(module->abi) +
           ", this is Tandem " TANDEM_ABI_VERSION "; rebuild it against this Tandem";
  if (module->component != component)
    return "does not contain TANDEM_COMPONENT(…, \"" + component + "\")";
  return "";
}

// Names of the components in `folder` whose modules may run in this process.
std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator{folder, missing}) {
    const std::string file = entry.path().filename();
    if (!file.starts_with(kModulePrefix) || !file.ends_with(kSuffix)) continue;
    const auto name =
        file.substr(kModulePrefix.size(), file.size() - kModulePrefix.size() - kSuffix.size());
    if (obstacle_to(read_module(entry.path()), name).empty()) names.insert(name);
  }
  return names;
}

std::string join(const std::set<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

[[noreturn]] void fail_unknown(const std::string& component) {
  std::set<std::string> known;
  std::string folders, found;
  for (const std::string& folder : component_folders()) {
    const auto names = names_in(folder);
    folders += (folders.empty() ? "" : ", ") + folder;
    if (!names.empty()) found += "; in " + folder + ": " + join(names);
    known.insert(names.begin(), names.end());
  }
  throw std::invalid_argument(
      "unknown component '" + component + "'" + did_you_mean(component, known) +
      (found.empty() ? "; there is none in " + folders : found) +
      (std::getenv("TANDEM_COMPONENT_PATH") == nullptr
           ? " (TANDEM_COMPONENT_PATH, which may name other folders, is not set)"
           : ""));
}

struct Module {
  fs::path file;
  std::string package;
};

// Throws std::invalid_argument as package_of() does.
Module find_module(const std::string& component) {
  check_module_name("component", component);
  for (const fs::path folder : component_folders()) {
    const fs::path file = folder / file_of(component);
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    if (fs::equivalent(file, runtime_file(), ignored))
      throw std::invalid_argument("'" + component + "' is no component: " + file.string() +
                                  " is the library that components use");
    const auto module = read_module(file);
    if (const auto obstacle = obstacle_to(module, component); !obstacle.empty())
      throw std::invalid_argument("component '" + component + "': " + file.string() + " " +
                                  obstacle);
    return {file, module->package.empty() ? component : module->package};
  }
  fail_unknown(component);
}

// Never unloaded: the library's code is in use until the process ends.
void open_library(const std::string& component) {
  if (dlopen(find_module(component).file.c_str(), RTLD_NOW | RTLD_LOCAL) == nullptr)
    throw std::invalid_argument("component '" + component + "': " + dlerror());
}

Component find(const std::string& component) {
  if (const auto known = find_registered(component)) return *known;
  open_library(component);
  if (const auto loaded = find_registered(component)) return *loaded;
  throw std::invalid_argument(file_of(component).string() + " registered no component '" +
                              component + "'");
}

// Otherwise the checks of parameter names would refuse a parameter that exists.
void require_described(const Node& node, const ComponentDescription& description) {
  const auto& fields = description.parameters;
  for (const auto& parameter : node.core()->parameters.all()) {
    const auto is_it = [&](const Field& field) { return field.name == parameter.name(); };
    if (is_parameter_of_every_node(parameter.name()) ||
        std::any_of(fields.begin(), fields.end(), is_it))
      continue;
    throw std::logic_error(node.name() + " declares the parameter `" + parameter.name() +
                           "`, which the component's `Params` do not have");
  }
}

}  // namespace

bool register_component(const char* name, const Component& component) {
  const std::lock_guard lock{registry().mutex};
  return registry().components.emplace(name, component).second;
}

const std::vector<std::string>& component_folders() {
  static const std::vector<std::string> folders = find_folders();
  return folders;
}

std::vector<std::string> list_components() {
  std::set<std::string> names;
  for (const auto& folder : component_folders()) names.merge(names_in(folder));
  const std::lock_guard lock{registry().mutex};
  for (const auto& [name, component] : registry().components) names.insert(name);
  return {names.begin(), names.end()};
}

std::string package_of(const std::string& component) { return find_module(component).package; }

ComponentDescription description_of(const std::string& component) {
  ComponentDescription description = find(component).describe();
  description.name = component;
  return description;
}

bool is_parameter_of_every_node(const std::string& name) {
  every_node::Params params;
  return names_of(params).contains(name) || name.starts_with(kQosOverrides);
}

void check_parameters(const std::string& component, const NodeOptions& options) {
  const ComponentDescription description = description_of(component);
  ParameterStore store{make_node_name(options.ns, options.name).full(), options.parameters};
  for (const Field& field : description.parameters) store.load(field);
  every_node::Params{}.visit(store);
  store.accept_all(kQosOverrides);
  store.check_unknown();
}

struct RunningComponent::State {
  State(const Component& component, NodeOptions options)
      : node{std::move(options)}, instance{component.make(node)} {
    node.check_parameters();
    require_described(node, component.describe());
  }
  Node node;
  std::shared_ptr<void> instance;
  std::optional<NodeThread> thread;  // last, because it ends first
};

RunningComponent::RunningComponent(const std::string& component, NodeOptions options) {
  const Component found = find(component);
  if (options.bus) {
    state_ = std::make_unique<State>(found, std::move(options));
    return;
  }
  const auto participant = Participant::shared();
  const Graph::Batch all_endpoints{participant->graph()};
  state_ = std::make_unique<State>(found, std::move(options));
}

RunningComponent::~RunningComponent() = default;
RunningComponent::RunningComponent(RunningComponent&&) noexcept = default;
RunningComponent& RunningComponent::operator=(RunningComponent&&) noexcept = default;

void RunningComponent::start() {
  Node& own = state_->node;
  if (!state_->thread && !own.core()->options.bus)
    state_->thread.emplace(own.name(), std::vector<Node*>{&own});
}

void RunningComponent::stop() { state_->node.stop(); }

void RunningComponent::join() {
  if (state_->thread) state_->thread->join();
}

Node& RunningComponent::node() const { return state_->node; }

RunningComponent load_component(const std::string& component, NodeOptions options) {
  RunningComponent running{component, std::move(options)};
  running.start();
  return running;
}

}  // namespace tandem::runtime
