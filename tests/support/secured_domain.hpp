// SPDX-License-Identifier: Apache-2.0
// Sets up a domain with DDS Security for this process and its children.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "bringup/system/keystore.hpp"
#include "support/private_domain.hpp"
#include "support/temporary_folder.hpp"
#include "tandem/runtime/dds_security.hpp"

namespace tandem::test {

/// Sets environment variables during this object's lifetime; an empty value unsets the variable.
class Variables {
 public:
  explicit Variables(const std::map<std::string, std::string>& wanted) {
    for (const auto& [name, value] : wanted) {
      const char* before = std::getenv(name.c_str());
      before_[name] = before == nullptr ? std::nullopt : std::optional<std::string>{before};
      set(name, value);
    }
  }
  ~Variables() {
    for (const auto& [name, value] : before_) set(name, value.value_or(""));
  }
  Variables(const Variables&) = delete;
  Variables& operator=(const Variables&) = delete;

 private:
  static void set(const std::string& name, const std::string& value) {
    if (value.empty())
      unsetenv(name.c_str());
    else
      setenv(name.c_str(), value.c_str(), 1);
  }

  std::map<std::string, std::optional<std::string>> before_;
};

[[nodiscard]] inline int domain_of_test() { return std::atoi(std::getenv("ROS_DOMAIN_ID")); }

/// A separate keystore. This process uses the enclave /watcher, which has all permissions.
class SecuredDomain {
 public:
  SecuredDomain() {
    create_keystore(keystore(), domain_of_test());
    add("/watcher", all_permissions());
    runtime::set_enclave("/watcher");
  }
  ~SecuredDomain() { runtime::set_enclave("/"); }
  SecuredDomain(const SecuredDomain&) = delete;
  SecuredDomain& operator=(const SecuredDomain&) = delete;

  void add(const std::string& enclave, const Permissions& permissions,
           const Validity& validity = usual_validity()) const {
    create_enclave(keystore(), enclave, permissions, domain_of_test(), validity);
  }
  /// Creates one enclave for each node of a system.
  void add_system(const std::string& file) const {
    for (const auto& node : load_system(file).nodes)
      add("/" + node.options.name, permissions_of(node));
  }
  [[nodiscard]] std::filesystem::path keystore() const { return folder_.path() / "keys"; }
  [[nodiscard]] std::filesystem::path enclave(const std::string& name) const {
    return keystore() / ("enclaves" + name);
  }

 private:
  TemporaryFolder folder_;
  Variables variables_{{{"ROS_SECURITY_ENABLE", "true"},
                        {"ROS_SECURITY_STRATEGY", "Enforce"},
                        {"ROS_SECURITY_KEYSTORE", keystore().string()}}};
};

}  // namespace tandem::test
