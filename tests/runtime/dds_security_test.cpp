// SPDX-License-Identifier: Apache-2.0
// Tests that environment and files give the same DDS security properties as in rcl and SROS2.
#include "tandem/runtime/dds_security.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "support/temporary_folder.hpp"
#include "tandem/runtime/arguments.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariables[] = {"ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY",
                                      "ROS_SECURITY_KEYSTORE", "ROS_SECURITY_ENCLAVE_OVERRIDE"};

// A keystore with the files of an enclave; their contents are not read here.
class DdsSecurity : public testing::Test {
 protected:
  DdsSecurity() {
    for (const char* file : {"identity_ca.cert.pem", "cert.pem", "key.pem",
                             "permissions_ca.cert.pem", "governance.p7s", "permissions.p7s"})
      put("a/b", file);
  }
  ~DdsSecurity() override {
    for (const char* name : kVariables) unsetenv(name);
    set_enclave("/");
  }

  void put(const std::string& enclave, const std::string& file) const {
    fs::create_directories(folder(enclave));
    std::ofstream{folder(enclave) / file} << "x";
  }
  [[nodiscard]] fs::path folder(const std::string& enclave) const {
    return store_.path() / "enclaves" / enclave;
  }
  [[nodiscard]] SecurityRequest request(bool enforced = true) const {
    return {.enabled = true, .enforced = enforced, .keystore = store_.path(), .override_with = ""};
  }
  [[nodiscard]] static std::string complaint(const SecurityRequest& request,
                                             const std::string& enclave) {
    try {
      (void)find_security(request, enclave);
      return {};
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  test::TemporaryFolder store_;
};

TEST_F(DdsSecurity, GivesThePluginsAndTheSixFilesOfAnEnclave) {
  const auto security = find_security(request(), "/a/b");
  const std::string url = "file://" + folder("a/b").string() + "/";
  const std::vector<std::pair<std::string, std::string>> expected{
      {"dds.sec.auth.plugin", "builtin.PKI-DH"},
      {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
      {"dds.sec.access.plugin", "builtin.Access-Permissions"},
      {"dds.sec.auth.builtin.PKI-DH.identity_ca", url + "identity_ca.cert.pem"},
      {"dds.sec.auth.builtin.PKI-DH.identity_certificate", url + "cert.pem"},
      {"dds.sec.auth.builtin.PKI-DH.private_key", url + "key.pem"},
      {"dds.sec.access.builtin.Access-Permissions.permissions_ca", url + "permissions_ca.cert.pem"},
      {"dds.sec.access.builtin.Access-Permissions.governance", url + "governance.p7s"},
      {"dds.sec.access.builtin.Access-Permissions.permissions", url + "permissions.p7s"}};
  EXPECT_EQ(security.properties, expected);
  EXPECT_EQ(security.folder, folder("a/b"));
  EXPECT_TRUE(security.complaint.empty());
}

TEST_F(DdsSecurity, GivesTheListOfRevokedCertificatesIfThereIsOne) {
  put("a/b", "crl.pem");
  EXPECT_EQ(find_security(request(), "/a/b").properties.back(),
            (std::pair<std::string, std::string>{"dds.sec.auth.builtin.PKI-DH.identity_crl",
                                                 "file://" + folder("a/b").string() + "/crl.pem"}));
}

TEST_F(DdsSecurity, EachMissingFileIsNamedAndKeepsAnEnforcedProcessFromStarting) {
  for (const char* file : {"identity_ca.cert.pem", "cert.pem", "key.pem", "permissions_ca.cert.pem",
                           "governance.p7s", "permissions.p7s"}) {
    fs::remove(folder("a/b") / file);
    const std::string text = complaint(request(), "/a/b");
    EXPECT_NE(text.find((folder("a/b") / file).string()), std::string::npos) << text;
    EXPECT_NE(text.find("tandem security create"), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
    put("a/b", file);
  }
}

TEST_F(DdsSecurity, AMissingEnclaveOrKeystoreIsNamed) {
  EXPECT_NE(complaint(request(), "/c").find(folder("c").string()), std::string::npos);
  EXPECT_NE(complaint(request(), "/").find("--enclave"), std::string::npos);
  EXPECT_NE(complaint({.enabled = true, .enforced = true, .keystore = "", .override_with = ""}, "/")
                .find("ROS_SECURITY_KEYSTORE"),
            std::string::npos);
}

TEST_F(DdsSecurity, APermissiveProcessStartsUnsecuredAndSaysWhatIsMissing) {
  fs::remove(folder("a/b") / "cert.pem");
  const auto security = find_security(request(false), "/a/b");
  EXPECT_FALSE(security.on());
  EXPECT_NE(security.complaint.find("cert.pem"), std::string::npos);
}

TEST_F(DdsSecurity, DisabledReadsNoFiles) {
  const auto security = find_security({}, "/no/such");
  EXPECT_FALSE(security.on());
  EXPECT_TRUE(security.complaint.empty());
}

TEST_F(DdsSecurity, AnOverrideReplacesTheEnclave) {
  auto overridden = request();
  overridden.override_with = "/a/b";
  EXPECT_EQ(find_security(overridden, "/c").folder, folder("a/b"));
}

TEST_F(DdsSecurity, ReadsRclsVariables) {
  EXPECT_FALSE(read_security_request().enabled);
  setenv("ROS_SECURITY_ENABLE", "false", 1);
  setenv("ROS_SECURITY_STRATEGY", "Enforce", 1);
  EXPECT_FALSE(read_security_request().enabled);
  setenv("ROS_SECURITY_ENABLE", "true", 1);
  setenv("ROS_SECURITY_KEYSTORE", "/keys", 1);
  setenv("ROS_SECURITY_ENCLAVE_OVERRIDE", "/a/b", 1);
  const auto request = read_security_request();
  EXPECT_TRUE(request.enabled);
  EXPECT_TRUE(request.enforced);
  EXPECT_EQ(request.keystore, "/keys");
  EXPECT_EQ(request.override_with, "/a/b");
  setenv("ROS_SECURITY_STRATEGY", "Permissive", 1);
  EXPECT_FALSE(read_security_request().enforced);
}

// rcl silently treats these as "unsecured" or "permissive".
TEST_F(DdsSecurity, RefusesValuesThatAreAlmostRight) {
  setenv("ROS_SECURITY_ENABLE", "1", 1);
  EXPECT_THROW((void)read_security_request(), std::runtime_error);
  setenv("ROS_SECURITY_ENABLE", "true", 1);
  setenv("ROS_SECURITY_STRATEGY", "enforce", 1);
  EXPECT_THROW((void)read_security_request(), std::runtime_error);
  setenv("ROS_SECURITY_STRATEGY", "Enforce", 1);
  setenv("ROS_SECURITY_ENCLAVE_OVERRIDE", "../a", 1);
  EXPECT_THROW((void)read_security_request(), std::runtime_error);
}

TEST_F(DdsSecurity, TheCommandLineSetsTheEnclave) {
  EXPECT_EQ(enclave(), "/");
  EXPECT_TRUE(parse_ros_arguments({"--ros-args", "--enclave", "/a/b"}).rest.empty());
  EXPECT_EQ(enclave(), "/a/b");
  (void)parse_ros_arguments({"--ros-args", "-e", "/c"});
  EXPECT_EQ(enclave(), "/c");
  EXPECT_THROW((void)parse_ros_arguments({"--ros-args", "--enclave", "c"}), std::invalid_argument);
  EXPECT_THROW((void)parse_ros_arguments({"--ros-args", "--enclave", "/.."}),
               std::invalid_argument);
}

TEST(Governance, ProtectsEveryDatagramOnlyIfEachDomainsRuleDoes) {
  const std::string closed =
      "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>";
  const auto rtps = [](const std::string& kind) {
    return "<rtps_protection_kind>" + kind + "</rtps_protection_kind>";
  };
  EXPECT_TRUE(protects_every_datagram(closed + rtps("SIGN")));
  EXPECT_TRUE(protects_every_datagram(closed + rtps("ENCRYPT_WITH_ORIGIN_AUTHENTICATION")));
  EXPECT_FALSE(protects_every_datagram(closed + rtps("NONE")));
  EXPECT_FALSE(protects_every_datagram(closed + rtps("SIGN") + closed + rtps("NONE")));
  EXPECT_FALSE(protects_every_datagram(
      "<allow_unauthenticated_participants>true</allow_unauthenticated_participants>" +
      rtps("SIGN")));
  EXPECT_FALSE(protects_every_datagram(""));
}

}  // namespace
}  // namespace tandem::runtime
