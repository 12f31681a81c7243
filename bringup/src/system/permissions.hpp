// SPDX-License-Identifier: Apache-2.0
// What an enclave may do: from the topics of its nodes to DDS Security's permissions document.
#pragma once

#include <ctime>
#include <set>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"

namespace tandem {

/// DDS topics ("rt/cmd_vel", "rq/node/get_parametersRequest"), or patterns of them ("rt/*").
struct Permissions {
  std::set<std::string> publish, subscribe;

  /// Adds those of others.
  void add(const Permissions& others);
};

/// Topics and services by their ROS 2 names ("/cmd_vel", "/a/*"; "*" is all of them).
void allow_publish(Permissions& permissions, const std::string& topic);
void allow_subscribe(Permissions& permissions, const std::string& topic);
void allow_serve(Permissions& permissions, const std::string& service);
void allow_call(Permissions& permissions, const std::string& service);

/// Everything on every topic and service, as `ros2 security create_enclave` gives at first.
[[nodiscard]] Permissions all_permissions();
/// What every process needs: the graph of nodes, and the names that each of `nodes` uses besides
/// its own topics (log, clock, parameters).
[[nodiscard]] Permissions permissions_of_any(const std::vector<rt::NodeOptions>& nodes);
/// What the node of a system uses, under its name and remappings. Throws std::invalid_argument for
/// a component that is not ours: its topics are not known.
[[nodiscard]] Permissions permissions_of(const SystemNode& node);

/// The seconds since 1970 between which a certificate or a document holds.
struct Validity {
  std::time_t from, until;
};

/// The permissions document of `enclave` in `domain`, unsigned.
[[nodiscard]] std::string permissions_document(const std::string& enclave,
                                               const Permissions& permissions,
                                               const Validity& validity, int domain);
/// The governance document of `domain`, unsigned: nobody unauthenticated; discovery, liveliness and
/// data are encrypted, messages signed; each topic needs a permission.
[[nodiscard]] std::string governance_document(int domain);

}  // namespace tandem
