// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/dds_security.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdexcept>

#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnable = "ROS_SECURITY_ENABLE";
constexpr const char* kStrategy = "ROS_SECURITY_STRATEGY";
constexpr const char* kKeystore = "ROS_SECURITY_KEYSTORE";
constexpr const char* kOverride = "ROS_SECURITY_ENCLAVE_OVERRIDE";

constexpr const char* kAuthentication = "dds.sec.auth.builtin.PKI-DH.";
constexpr const char* kAccess = "dds.sec.access.builtin.Access-Permissions.";

struct SecurityFile {
  const char* prefix;
  const char* property;
  const char* name;
};
constexpr std::array<SecurityFile, 6> kFiles{{
    {kAuthentication, "identity_ca", "identity_ca.cert.pem"},
    {kAuthentication, "identity_certificate", "cert.pem"},
    {kAuthentication, "private_key", "key.pem"},
    {kAccess, "permissions_ca", "permissions_ca.cert.pem"},
    {kAccess, "governance", "governance.p7s"},
    {kAccess, "permissions", "permissions.p7s"},
}};
constexpr SecurityFile kRevoked{kAuthentication, "identity_crl", "crl.pem"};  // optional

// True for `yes`, false for `no` or empty.
bool choice_from(const char* name, const std::string& yes, const std::string& no) {
  const std::string text = variable(name);
  if (text == yes) return true;
  if (text.empty() || text == no) return false;
  throw std::runtime_error(std::string{name} + " = '" + text + "' is neither " + yes + " nor " +
                           no + "; refusing to start, because ROS 2 would read it as " + no);
}

bool is_enclave(const std::string& name) { return name == "/" || is_full_name(name); }

std::pair<std::string, std::string> property_of(const SecurityFile& file, const fs::path& folder) {
  return {std::string{file.prefix} + file.property, "file://" + (folder / file.name).string()};
}

// Instructions for creating an enclave's files.
std::string mending(const SecurityRequest& request, const std::string& enclave) {
  if (enclave == "/")
    return "no enclave is given: use --enclave /NAME or " + std::string{kOverride} + "=/NAME";
  return "`tandem security create " + request.keystore +
         " …` creates enclaves, and --enclave selects another one";
}

// Error text naming what is missing and the remedy; empty if complete.
std::string missing(const SecurityRequest& request, const std::string& enclave,
                    const fs::path& folder) {
  if (request.keystore.empty())
    return std::string{kKeystore} + " is not set; set it to the keystore's folder";
  if (!fs::is_directory(folder))
    return "there is no folder " + folder.string() + "; " + mending(request, enclave);
  for (const auto& file : kFiles)
    if (!fs::is_regular_file(folder / file.name))
      return "there is no file " + (folder / file.name).string() + "; " + mending(request, enclave);
  return {};
}

// Absolute, so that error messages show the full path; empty without a keystore.
fs::path folder_of(const std::string& keystore, const std::string& enclave) {
  if (keystore.empty()) return {};
  const fs::path folder = fs::absolute(keystore) / "enclaves" / enclave.substr(1);
  return folder.lexically_normal();
}

std::string text_in(const fs::path& file) {
  std::ifstream stream{file};
  return {std::istreambuf_iterator<char>{stream}, {}};
}

// The contents of every <name>…</name> element.
std::vector<std::string> values_of(const std::string& name, const std::string& document) {
  const std::string begin = "<" + name + ">", end = "</" + name + ">";
  std::vector<std::string> values;
  for (auto at = document.find(begin); at != std::string::npos; at = document.find(begin, at)) {
    at += begin.size();
    values.push_back(document.substr(at, document.find(end, at) - at));
  }
  return values;
}

std::mutex enclave_mutex;
std::string process_enclave = "/";

}  // namespace

bool protects_every_datagram(const std::string& governance) {
  const auto values = values_of("rtps_protection_kind", governance);
  const auto strangers = values_of("allow_unauthenticated_participants", governance);
  const auto protects = [](const std::string& kind) { return kind.find("NONE") == kind.npos; };
  const auto refuses = [](const std::string& flag) {
    return flag.find("false") != flag.npos || flag.find("FALSE") != flag.npos;
  };
  return !values.empty() && !strangers.empty() &&
         std::all_of(values.begin(), values.end(), protects) &&
         std::all_of(strangers.begin(), strangers.end(), refuses);
}

SecurityRequest read_security_request() {
  SecurityRequest request;
  request.enabled = choice_from(kEnable, "true", "false");
  if (!request.enabled) return request;
  request.enforced = choice_from(kStrategy, "Enforce", "Permissive");
  request.keystore = variable(kKeystore);
  request.override_with = variable(kOverride);
  if (!request.override_with.empty() && !is_enclave(request.override_with))
    throw std::runtime_error(std::string{kOverride} + " = '" + request.override_with +
                             "' is not an enclave name; write / or /a/b");
  return request;
}

Security find_security(const SecurityRequest& request, const std::string& enclave) {
  if (!request.enabled) return {};
  const std::string wanted = request.override_with.empty() ? enclave : request.override_with;
  const fs::path folder = folder_of(request.keystore, wanted);
  if (const std::string what = missing(request, wanted, folder); !what.empty()) {
    if (request.enforced)
      throw std::runtime_error(std::string{kStrategy} + "=Enforce, and " + what);
    Security unsecured;
    unsecured.folder = folder;
    unsecured.complaint = what;
    return unsecured;
  }
  Security security;
  security.folder = folder;
  security.protects_all = protects_every_datagram(text_in(folder / "governance.p7s"));
  security.properties = {{"dds.sec.auth.plugin", "builtin.PKI-DH"},
                         {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
                         {"dds.sec.access.plugin", "builtin.Access-Permissions"}};
  for (const auto& file : kFiles) security.properties.push_back(property_of(file, folder));
  if (fs::is_regular_file(folder / kRevoked.name))
    security.properties.push_back(property_of(kRevoked, folder));
  return security;
}

void set_enclave(const std::string& name) {
  if (!is_enclave(name))
    throw std::invalid_argument("--enclave '" + name + "' is not an enclave name; write / or /a/b");
  const std::lock_guard lock{enclave_mutex};
  process_enclave = name;
}

std::string enclave() {
  const std::lock_guard lock{enclave_mutex};
  return process_enclave;
}

}  // namespace tandem::runtime
