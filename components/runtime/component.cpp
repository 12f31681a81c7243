// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/component.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tandem/runtime/detail/graph.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "libtandem_";
constexpr std::string_view kSuffix = ".so";

struct Registry {
  std::mutex mutex;
  std::map<std::string, MakeComponent> components;
};

Registry& registry() {
  static Registry all;
  return all;
}

MakeComponent find_registered(const std::string& name) {
  const std::lock_guard lock{registry().mutex};
  const auto found = registry().components.find(name);
  return found == registry().components.end() ? nullptr : found->second;
}

// The folder of libtandem_runtime.so.
fs::path library_folder() {
  Dl_info info{};
  dladdr(reinterpret_cast<const void*>(&registry), &info);
  return fs::path{info.dli_fname}.parent_path();
}

// Component names for which `folder` has a library.
std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator{folder, missing}) {
    const std::string file = entry.path().filename();
    if (!file.starts_with(kPrefix) || !file.ends_with(kSuffix)) continue;
    const auto name = file.substr(kPrefix.size(), file.size() - kPrefix.size() - kSuffix.size());
    if (name != "runtime" && name != "msgs") names.insert(name);
  }
  return names;
}

std::string join(const std::set<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "none" : all;
}

[[noreturn]] void fail_unknown(const std::string& component) {
  std::ostringstream text;
  text << "unknown component '" << component << "'; found";
  for (const auto& folder : component_folders())
    text << " in " << folder << ": " << join(names_in(folder)) << ";";
  throw std::invalid_argument(text.str());
}

// Never unloaded: the library's code is in use until the process ends.
void open_library(const std::string& component) {
  const std::string file = std::string{kPrefix} + component + std::string{kSuffix};
  for (const auto& folder : component_folders()) {
    const fs::path path = fs::path{folder} / file;
    if (!fs::exists(path)) continue;
    if (dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL) == nullptr)
      throw std::invalid_argument("component '" + component + "': " + dlerror());
    return;
  }
  fail_unknown(component);
}

MakeComponent find(const std::string& component) {
  if (const auto known = find_registered(component)) return known;
  open_library(component);
  if (const auto loaded = find_registered(component)) return loaded;
  throw std::invalid_argument(std::string{kPrefix} + component + std::string{kSuffix} +
                              " does not contain TANDEM_COMPONENT(…, \"" + component + "\")");
}

// An exception in a callback ends the process; the timeouts of downstream nodes then stop the
// robot.
void spin(Node& node) {
  try {
    node.spin();
  } catch (const std::exception& error) {
    node.log().error("exception in a callback; the process exits: {}", error.what());
    std::_Exit(EXIT_FAILURE);
  }
}

}  // namespace

bool register_component(const char* name, MakeComponent make) {
  const std::lock_guard lock{registry().mutex};
  return registry().components.emplace(name, make).second;
}

std::vector<std::string> component_folders() {
  std::vector<std::string> folders;
  if (const char* path = std::getenv("TANDEM_COMPONENT_PATH")) {
    std::istringstream stream{path};
    for (std::string folder; std::getline(stream, folder, ':');)
      if (!folder.empty()) folders.push_back(folder);
  }
  folders.push_back(library_folder());
  folders.push_back(library_folder() / "tandem");
  return folders;
}

std::vector<std::string> list_components() {
  std::set<std::string> names;
  for (const auto& folder : component_folders()) names.merge(names_in(folder));
  const std::lock_guard lock{registry().mutex};
  for (const auto& [name, make] : registry().components) names.insert(name);
  return {names.begin(), names.end()};
}

struct RunningComponent::State {
  State(MakeComponent make, NodeOptions options) : node{std::move(options)}, component{make(node)} {
    node.check_parameters();
  }
  ~State() {
    node.stop();
    if (thread.joinable()) thread.join();
  }

  Node node;
  std::shared_ptr<void> component;
  std::thread thread;
};

RunningComponent::RunningComponent(const std::string& component, NodeOptions options) {
  const MakeComponent make = find(component);
  const auto participant = Participant::shared();
  const Graph::Batch all_endpoints{participant->graph()};
  state_ = std::make_unique<State>(make, std::move(options));
}

RunningComponent::~RunningComponent() = default;
RunningComponent::RunningComponent(RunningComponent&&) noexcept = default;
RunningComponent& RunningComponent::operator=(RunningComponent&&) noexcept = default;

void RunningComponent::start() {
  if (!state_->thread.joinable())
    state_->thread = std::thread{[this_state = state_.get()] { spin(this_state->node); }};
}

void RunningComponent::stop() { state_->node.stop(); }

void RunningComponent::join() {
  if (state_->thread.joinable()) state_->thread.join();
}

Node& RunningComponent::node() const { return state_->node; }

RunningComponent load_component(const std::string& component, NodeOptions options) {
  RunningComponent running{component, std::move(options)};
  running.start();
  return running;
}

}  // namespace tandem::runtime
