// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/security_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/system/keystore.hpp"
#include "bringup/system/permissions.hpp"
#include "bringup/system/system.hpp"
#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

using Enclaves = std::map<std::string, Permissions>;

struct CreateRequest {
  std::filesystem::path keystore;
  std::vector<std::string> enclaves;
  std::string system;
  std::vector<std::string> only;
  std::vector<std::string> publish, subscribe, call;

  [[nodiscard]] bool names_topics() const {
    return !publish.empty() || !subscribe.empty() || !call.empty();
  }
};

std::vector<SystemNode> nodes_of(const CreateRequest& request) {
  System system = load_system(request.system);
  require_names(system, request.only);
  std::erase_if(system.nodes, [&](const SystemNode& node) {
    return !request.only.empty() && std::find(request.only.begin(), request.only.end(),
                                              node.options.name) == request.only.end();
  });
  return std::move(system.nodes);
}

std::string full_name(const SystemNode& node) {
  return rt::make_node_name(node.options.ns, node.options.name).full();
}

// One enclave for each process that `run --separate` starts.
Enclaves separate_enclaves(const std::vector<SystemNode>& nodes) {
  Enclaves all;
  for (const auto& node : nodes) all[full_name(node)] = permissions_of(node);
  return all;
}

Permissions composed_permissions(const std::vector<SystemNode>& nodes) {
  Permissions all;
  std::string names;
  for (const auto& node : nodes) {
    all.add(permissions_of(node));
    names += (names.empty() ? "" : ", ") + full_name(node);
  }
  std::printf(
      "These nodes share a process and therefore the permissions of all of them: %s.\n"
      "For separate permissions, omit the enclave's name and run the nodes with --separate.\n",
      names.c_str());
  return all;
}

// Permissions of a program with one node, whose name is that of the enclave.
Permissions listed_permissions(const CreateRequest& request, const std::string& enclave) {
  const auto slash = enclave.rfind('/');
  Permissions all = permissions_of_any(
      {{.name = enclave.substr(slash + 1), .ns = slash == 0 ? "/" : enclave.substr(0, slash)}});
  for (const auto& topic : request.publish) allow_publish(all, topic);
  for (const auto& topic : request.subscribe) allow_subscribe(all, topic);
  for (const auto& service : request.call) allow_call(all, service);
  return all;
}

Enclaves enclaves_of(const CreateRequest& request) {
  if (!request.system.empty()) {
    const auto nodes = nodes_of(request);
    if (request.enclaves.empty()) return separate_enclaves(nodes);
    if (request.enclaves.size() > 1)
      throw std::invalid_argument(
          "--system takes at most one enclave: name one for all nodes in one process, or none for "
          "an enclave for each node");
    return {{request.enclaves.front(), composed_permissions(nodes)}};
  }
  if (request.enclaves.empty())
    throw std::invalid_argument("name an enclave, or give a system file with --system");
  Enclaves all;
  for (const auto& enclave : request.enclaves)
    all[enclave] =
        request.names_topics() ? listed_permissions(request, enclave) : all_permissions();
  return all;
}

// Enclaves with permissions for a domain that the governance file does not name cannot join.
void warn_of_domain(const std::filesystem::path& keystore, int domain) {
  std::ifstream file{keystore / "enclaves" / "governance.xml"};
  const std::string text{std::istreambuf_iterator<char>{file}, {}};
  if (text.find(fmt::format("<id>{}</id>", domain)) == std::string::npos)
    std::fprintf(
        stderr,
        "tandem: enclaves/governance.xml does not list domain %d (ROS_DOMAIN_ID), for which "
        "these enclaves were created\n",
        domain);
}

void warn_of_size(const std::filesystem::path& keystore, const std::string& enclave) {
  const auto size = file_size(keystore / ("enclaves" + enclave) / "permissions.p7s");
  if (size > kShortPermissions)
    std::fprintf(
        stderr,
        "tandem: %s has %ju bytes of permissions; Fast DDS 2.14.4 to 3.2.2 (Debian 13) cannot "
        "send more than about %zu. There, make an enclave for each node and run them with "
        "--separate, or use patterns (--publish '/a/*')\n",
        enclave.c_str(), static_cast<std::uintmax_t>(size), kShortPermissions);
}

void print_drivers(const Enclaves& enclaves) {
  std::string drivers;
  for (const auto& [name, permissions] : enclaves)
    if (permissions.publish.contains("rt/cmd_vel") || permissions.publish.contains("rt/*"))
      drivers += " " + name;
  std::printf("/cmd_vel may be published by:%s\n", drivers.empty() ? " none" : drivers.c_str());
}

// Without a choice, an enclave gets all permissions; this must not overwrite a choice made earlier.
void require_choice(const CreateRequest& request) {
  if (!request.system.empty() || request.names_topics()) return;
  for (const auto& enclave : request.enclaves)
    if (const auto file = request.keystore / ("enclaves" + enclave) / "permissions.p7s";
        std::filesystem::exists(file))
      throw std::invalid_argument(file.string() +
                                  " already exists; give the enclave's permissions with --system, "
                                  "--publish, --subscribe or --call, or remove its folder");
}

void create(const CreateRequest& request) {
  require_choice(request);
  const int domain = rt::read_environment().domain;
  const Enclaves enclaves = enclaves_of(request);
  create_keystore(request.keystore, domain);
  warn_of_domain(request.keystore, domain);
  for (const auto& [name, permissions] : enclaves) {
    create_enclave(request.keystore, name, permissions, domain);
    std::printf("%s: publishes to %zu DDS topics, subscribes to %zu\n", name.c_str(),
                permissions.publish.size(), permissions.subscribe.size());
    warn_of_size(request.keystore, name);
  }
  print_drivers(enclaves);
}

}  // namespace

void add_security_command(CLI::App& app) {
  auto* security = app.add_subcommand("security", "Keys and permissions for DDS Security");
  security->require_subcommand(1);
  auto* command = security->add_subcommand(
      "create", "Create a keystore like that of `ros2 security`, and enclaves in it");
  auto request = std::make_shared<CreateRequest>();
  command->add_option("keystore", request->keystore, "folder of the keystore")->required();
  command->add_option("enclaves", request->enclaves,
                      "/NAME of each; may use all topics unless options restrict it");
  auto* system =
      command
          ->add_option("--system", request->system,
                       "system file: its nodes' permissions, in an enclave /NODE for each "
                       "node, or in the named enclave for all nodes")
          ->check(CLI::ExistingFile);
  command->add_option("--only", request->only, "only these nodes of the system")->needs(system);
  for (auto& [name, list, what] :
       {std::tuple{"--publish", &request->publish, "topics that the enclaves may publish"},
        std::tuple{"--subscribe", &request->subscribe, "topics that they may subscribe to"},
        std::tuple{"--call", &request->call, "services that they may call"}})
    command->add_option(name, *list, what)->excludes(system);
  command->footer(
      "The domain is ROS_DOMAIN_ID. A program in an enclave with --publish, --subscribe or --call "
      "must give its node the enclave's name. Certificates are valid for ten years; expired ones "
      "are replaced.");
  command->callback([request] { create(*request); });
}

}  // namespace tandem
