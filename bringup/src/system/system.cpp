// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/system.hpp"

#include <malloc.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "bringup/system/parameter_names.hpp"
#include "bringup/system/processes.hpp"
#include "bringup/system/shared_files.hpp"
#include "bringup/system/unused_remappings.hpp"
#include "tandem/config/yaml_reader.hpp"
#include "tandem/runtime/arguments.hpp"
#include "tandem/runtime/dds_security.hpp"
#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/parameter_files.hpp"
#include "tandem/runtime/real_time.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDdsThreads = "dds";  // a name under `real_time`

// `$(dirname)` is the system file's folder, as in ROS 2's launch files.
std::string with_folder(std::string text, const std::string& path) {
  static const std::string kDirname = "$(dirname)";
  const std::string folder = fs::absolute(path).parent_path().string();
  for (auto at = text.find(kDirname); at != std::string::npos;
       at = text.find(kDirname, at + folder.size()))
    text.replace(at, kDirname.size(), folder);
  return text;
}

// The paths of the list under a key; none without it.
std::vector<std::string> read_paths(YamlReader& map, const char* key) {
  std::vector<std::string> paths;
  if (const auto list = map.optional(key))
    for (const YamlReader& value : list->elements()) paths.push_back(find_file(value, "robots"));
  return paths;
}

SystemNode read_node(YamlReader& map, const std::string& path) {
  SystemNode node{.component = map.required<std::string>("component"), .options = {}};
  auto& options = node.options;
  options.name = map.optional("name", node.component);
  options.ns = map.optional("namespace", options.ns);
  node.thread = map.optional("thread", node.thread);
  node.respawn = map.optional("respawn", node.respawn);
  options.parameters.files = read_paths(map, "parameter_files");
  if (auto parameters = map.optional("parameters"))
    for (const auto& [key, value] : parameters->rest())
      options.parameters.values[key] = {with_folder(value.text(), path), value.place()};
  if (auto remappings = map.optional("remappings"))
    for (const auto& [from, to] : remappings->rest())
      options.remappings[from] = to.as<std::string>();
  map.finish();
  return node;
}

// Takes the priorities of threads, by the names that they have in the file.
void read_real_time(YamlReader& map, System& system) {
  std::set<std::string> threads{kDdsThreads};
  for (const auto& node : system.nodes) threads.insert(node.thread_name());
  for (const auto& [thread, value] : map.rest()) {
    if (!threads.contains(thread))
      value.fail(
          fmt::format("{}: no such thread; there are: {}", value.key(), fmt::join(threads, ", ")));
    const int priority = value.as<int>();
    (void)value.number(1, 99);
    if (thread == kDdsThreads) system.dds_priority = priority;
    for (auto& node : system.nodes)
      if (node.thread_name() == thread) node.priority = priority;
  }
}

bool wanted(const SystemNode& node, const std::vector<std::string>& only) {
  return only.empty() || std::find(only.begin(), only.end(), node.options.name) != only.end();
}

// [s]; after it, the memory that only the start needed is given back, which takes 1 ms.
constexpr double kStart = 3.0;

// Without it, a system in which all is well would print nothing.
void announce(const System& system) {
  rt::Logger{"tandem"}.info("running the {} nodes of {} in domain {}; Ctrl-C stops them",
                            system.nodes.size(), system.path, rt::read_environment().domain);
}

int run_here(const System& system, const std::vector<std::string>& only) {
  RunningSystem running{system, only};
  if (only.empty()) announce(system);
  if (only.empty())  // a separate process does not know the other processes' parameters
    for (const auto& key : rt::unused_wildcard_keys())
      rt::Logger{"tandem"}.warn("{}: unknown parameter; no component of {} has it", key,
                                system.path);
  if (!rt::wait_for_shutdown(kStart)) malloc_trim(0);
  rt::wait_for_shutdown();
  running.stop();
  running.wait();
  return 0;
}

// A `-p` without a node name applies to every node that has the parameter. Separate processes do
// not know each other's parameters, so look in all components; a node may still declare others.
void warn_of_unknown(const rt::RosArguments& arguments) {
  const auto all = arguments.parameters.find("");
  if (all == arguments.parameters.end()) return;
  for (const auto& [key, value] : all->second) {
    if (is_parameter(key)) continue;
    rt::Logger{"tandem"}.warn("-p {}:={}: unknown parameter `{}`{}", key, value, key,
                              nearest_parameter(key));
  }
}

void warn_of_strangers(const System& system, const rt::RosArguments& arguments) {
  std::vector<rt::NodeOptions> nodes;
  for (const auto& node : system.nodes) nodes.push_back(node.options);
  std::set<std::string> files{arguments.parameter_files.begin(), arguments.parameter_files.end()};
  std::vector<std::string> names;
  for (const auto& node : nodes) {
    const auto options = rt::with_arguments(node, arguments);
    names.push_back(rt::make_node_name(options.ns, options.name).full());
    files.insert(options.parameters.files.begin(), options.parameters.files.end());
  }
  for (const auto& file : files)
    for (const auto& section : rt::sections_for_nobody(file, names))
      rt::Logger{"tandem"}.warn("{}: {} has no node '{}'; the file's entry for it has no effect",
                                section.origin, system.path, section.name);
  for (const auto& name : rt::strangers_in(arguments, nodes))
    rt::Logger{"tandem"}.warn("--ros-args: {} has no node '{}'; its rules have no effect",
                              system.path, name);
  for (const auto& line : unused_remappings(system, arguments))
    rt::Logger{"tandem"}.warn("{}", line);
}

// Calls `use(component, options)` for a node; errors name the system file and the node.
template <class Use>
auto use_component(const System& system, const SystemNode& node, const Use& use) {
  try {
    return use(node.component, node.options);
  } catch (const std::exception& error) {
    const std::string what = error.what();
    if (what.find(": node /") != std::string::npos) throw;  // already names the node
    throw std::invalid_argument(system.path + ": " + node.options.name + ": " + what);
  }
}

rt::RunningComponent construct(const System& system, const SystemNode& node) {
  return use_component(system, node, [](const auto& component, const auto& options) {
    return rt::RunningComponent{component, options};
  });
}

// Checked once here, before every process reports the same error.
void check_parameters(const System& system, const std::vector<std::string>& only,
                      const rt::RosArguments& arguments) {
  for (const auto& node : system.nodes)
    if (wanted(node, only))
      use_component(
          system,
          {.component = node.component, .options = rt::with_arguments(node.options, arguments)},
          rt::check_parameters);
}

// A restarted arbitration does not know whether the emergency stop was pressed, so it must assume
// that it was.
std::vector<std::string> respawn_arguments(const SystemNode& node) {
  if (node.component != "arbitration") return {};
  return {"--ros-args", "-p", node.options.name + ":start_stopped:=true"};
}

// Arguments that give a separate process its enclave.
std::vector<std::string> enclave_arguments(const rt::NodeOptions& options) {
  if (rt::enclave() != "/") return {"--ros-args", "--enclave", rt::enclave()};
  if (!rt::read_security_request().enabled) return {};
  return {"--ros-args", "--enclave", rt::make_node_name(options.ns, options.name).full()};
}

std::vector<std::string> command_for(const std::string& path, const SystemNode& node,
                                     const std::vector<std::string>& ros_args) {
  std::vector<std::string> command{"run", path, "--only", node.options.name};
  command.insert(command.end(), ros_args.begin(), ros_args.end());
  const auto of_enclave =
      enclave_arguments(rt::with_arguments(node.options, rt::parse_ros_arguments(ros_args)));
  command.insert(command.end(), of_enclave.begin(), of_enclave.end());
  return command;
}

}  // namespace

void require_names(const System& system, const std::vector<std::string>& only) {
  for (const auto& name : only) {
    const auto found =
        std::find_if(system.nodes.begin(), system.nodes.end(),
                     [&](const SystemNode& node) { return node.options.name == name; });
    if (found == system.nodes.end())
      throw std::invalid_argument(system.path + ": no component is named '" + name + "'");
  }
}

System load_system(const std::string& path) {
  YamlReader root = YamlReader::load(path);
  const bool use_sim_time = root.optional("use_sim_time", false);
  const auto thread = root.optional("thread", std::string{});
  const auto files = read_paths(root, "parameter_files");
  System system{path, {}};
  if (const auto components = root.optional("components"))
    for (YamlReader& map : components->elements()) system.nodes.push_back(read_node(map, path));
  auto real_time = root.optional("real_time");
  root.finish();
  if (system.nodes.empty()) root.fail("no components");
  for (SystemNode& node : system.nodes) {
    auto& own = node.options.parameters.files;
    own.insert(own.begin(), files.begin(), files.end());
    node.options.use_sim_time = use_sim_time;
    if (node.thread.empty()) node.thread = thread;
  }
  if (real_time) read_real_time(*real_time, system);
  return system;
}

RunningSystem::RunningSystem(const System& system, const std::vector<std::string>& only) {
  require_names(system, only);
  rt::use_real_time_for_dds(system.dds_priority);
  struct Thread {
    std::string name;
    int priority;
    std::vector<rt::Node*> nodes;
  };
  std::vector<Thread> threads;
  components_.reserve(system.nodes.size());
  for (const auto& node : system.nodes) {
    if (!wanted(node, only)) continue;
    rt::Node& own = components_.emplace_back(construct(system, node)).node();
    if (node.options.bus) continue;  // a LocalBus runs its nodes itself
    const auto shared = std::find_if(threads.begin(), threads.end(), [&](const Thread& thread) {
      return !node.thread.empty() && thread.name == node.thread;
    });
    if (shared == threads.end())
      threads.push_back({node.thread_name(), node.priority, {&own}});
    else
      shared->nodes.push_back(&own);
  }
  for (const auto& thread : threads)
    threads_.push_back(
        std::make_unique<rt::NodeThread>(thread.name, thread.nodes, thread.priority));
}

void RunningSystem::stop() {
  for (auto& component : components_) component.stop();
}

void RunningSystem::wait() {
  for (auto& thread : threads_) thread->join();
}

int run_system(const std::string& path, const std::vector<std::string>& only,
               bool separate_processes, const std::vector<std::string>& ros_args) {
  System system = load_system(path);
  require_names(system, only);
  const auto arguments = rt::parse_ros_arguments(ros_args);
  if (!arguments.rest.empty())
    throw std::invalid_argument("unknown argument '" + arguments.rest.front() + "'");
  if (only.empty()) warn_of_strangers(system, arguments);  // each process would repeat the warnings
  rt::install_signal_handlers();
  if (separate_processes) {
    warn_of_unknown(arguments);
    check_parameters(system, only, arguments);
    if (only.empty()) announce(system);
    Processes processes;
    for (const auto& node : system.nodes)
      if (wanted(node, only))
        processes.start({node.options.name, command_for(path, node, ros_args), node.respawn,
                         respawn_arguments(node)});
    return processes.run();
  }
  for (auto& node : system.nodes) node.options = rt::with_arguments(node.options, arguments);
  return run_here(system, only);
}

}  // namespace tandem
