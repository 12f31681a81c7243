// SPDX-License-Identifier: Apache-2.0
// DDS Security as ROS 2 users ask for it (rcl's variables, SROS2's keystore). In: environment, the
// enclave, files. Out: the properties that DDS is given, or what is missing.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tandem::runtime {

/// What the environment asks for.
struct SecurityRequest {
  bool enabled = false;       ///< ROS_SECURITY_ENABLE=true
  bool enforced = false;      ///< ROS_SECURITY_STRATEGY=Enforce
  std::string keystore;       ///< ROS_SECURITY_KEYSTORE
  std::string override_with;  ///< ROS_SECURITY_ENCLAVE_OVERRIDE: an enclave, or empty
};

/// What DDS is given. Without properties the process is unsecured.
struct Security {
  std::vector<std::pair<std::string, std::string>> properties;
  std::string folder;     ///< of the enclave
  std::string complaint;  ///< why there are no properties although security is enabled

  /// Whether the governance protects every datagram of everybody.
  bool protects_all = false;

  [[nodiscard]] bool on() const { return !properties.empty(); }
};

/// Whether a governance document, signed or not, protects every datagram in each of its domains and
/// lets nobody in unauthenticated.
[[nodiscard]] bool protects_every_datagram(const std::string& governance);

/// Throws std::runtime_error naming a variable whose value ROS 2 does not have: rcl would take
/// ROS_SECURITY_ENABLE=1 for false, and speak unsecured.
[[nodiscard]] SecurityRequest read_security_request();

/// The properties of `enclave` ("/" or "/a/b"), or of the one that overrides it. Throws
/// std::runtime_error if security is enforced and a file is missing, saying which and what to do.
[[nodiscard]] Security find_security(const SecurityRequest& request, const std::string& enclave);

/// The enclave of this process, "/" unless it is set before the first node. Throws
/// std::invalid_argument for a name that is neither "/" nor of the form "/a/b".
void set_enclave(const std::string& name);
[[nodiscard]] std::string enclave();

}  // namespace tandem::runtime
