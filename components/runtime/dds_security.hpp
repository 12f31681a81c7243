// SPDX-License-Identifier: Apache-2.0
// Turns ROS 2's security settings (rcl's environment variables, SROS2's keystore) into DDS Security
// properties, or reports what is missing.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Security settings from the environment.
struct SecurityRequest {
  bool enabled = false;       ///< ROS_SECURITY_ENABLE=true
  bool enforced = false;      ///< ROS_SECURITY_STRATEGY=Enforce
  std::string keystore;       ///< ROS_SECURITY_KEYSTORE
  std::string override_with;  ///< ROS_SECURITY_ENCLAVE_OVERRIDE: an enclave, or empty
};

/// Security properties for DDS. Without properties the process is unsecured.
struct Security {
  std::vector<std::pair<std::string, std::string>> properties;  ///< name → value
  std::string folder;                                           ///< of the enclave
  std::string complaint;  ///< why there are no properties although security is enabled

  /// See protects_every_datagram().
  bool protects_all = false;

  /// Whether DDS Security is switched on.
  [[nodiscard]] bool on() const { return !properties.empty(); }
};

/// Whether a governance document, signed or not, protects every datagram in each of its domains and
/// refuses unauthenticated participants.
[[nodiscard]] TANDEM_EXPORT bool protects_every_datagram(const std::string& governance);

/// Throws std::runtime_error naming a variable whose value ROS 2 does not define: rcl would read
/// ROS_SECURITY_ENABLE=1 as false and communicate unsecured.
[[nodiscard]] TANDEM_EXPORT SecurityRequest read_security_request();

/// The properties of `enclave` ("/" or "/a/b"), or of the one that overrides it. Throws
/// std::runtime_error if security is enforced and a file is missing, naming the file and the
/// remedy.
[[nodiscard]] TANDEM_EXPORT Security find_security(const SecurityRequest& request,
                                                   const std::string& enclave);

/// The enclave of this process, "/" unless it is set before the first node. Throws
/// std::invalid_argument for a name that is neither "/" nor of the form "/a/b".
TANDEM_EXPORT void set_enclave(const std::string& name);
/// The enclave in force.
[[nodiscard]] TANDEM_EXPORT std::string enclave();

}  // namespace tandem::runtime
