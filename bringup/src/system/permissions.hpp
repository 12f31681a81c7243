// SPDX-License-Identifier: Apache-2.0
// Generates DDS Security's permissions document of an enclave from the topics of its nodes.
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

  /// Adds the topics of `others`.
  void add(const Permissions& others);
};

/// Topics and services by their ROS 2 names ("/cmd_vel", "/a/*"; "*" is all of them).
void allow_publish(Permissions& permissions, const std::string& topic);
void allow_subscribe(Permissions& permissions, const std::string& topic);
void allow_serve(Permissions& permissions, const std::string& service);
void allow_call(Permissions& permissions, const std::string& service);

/// Access to every topic and service, the default of `ros2 security create_enclave`.
[[nodiscard]] Permissions all_permissions();
/// Access that every process needs: the node graph, and for each of `nodes` its log, clock,
/// parameters and all services below its own name.
[[nodiscard]] Permissions permissions_of_any(const std::vector<rt::NodeOptions>& nodes);
/// The names a system's node uses, after renaming and remapping. Throws std::invalid_argument if
/// its component cannot be loaded.
[[nodiscard]] Permissions permissions_of(const SystemNode& node);

/// Signed permissions up to this size [bytes] can be sent by every Fast DDS. Those from 2.14.4 to
/// 3.2.2 (Debian 13 has 3.1.2) cannot send a handshake of more than 8192 bytes, of which
/// certificate, participant data and keys take up to 2000.
inline constexpr std::size_t kShortPermissions = 6000;

/// Validity period of a certificate or document [s since 1970].
struct Validity {
  std::time_t from, until;
};

/// The permissions document of `enclave` in `domain`, unsigned. Names that a pattern covers are
/// left out: it must be short enough for kShortPermissions.
[[nodiscard]] std::string permissions_document(const std::string& enclave,
                                               const Permissions& permissions,
                                               const Validity& validity, int domain);
/// The governance document of `domain`, unsigned: unauthenticated participants are refused;
/// discovery, liveliness and data are encrypted, messages signed; each topic needs a permission.
[[nodiscard]] std::string governance_document(int domain);

}  // namespace tandem
