// SPDX-License-Identifier: Apache-2.0
// Tests keystores: the layout is that of SROS2, and OpenSSL verifies the signatures.
#include "bringup/system/keystore.hpp"

#include <gtest/gtest.h>

#include <openssl/x509v3.h>

#include <fstream>
#include <iterator>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tandem/runtime/detail/security_fault.hpp"
#include "tandem/runtime/openssl.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

std::string text_in(const fs::path& file) {
  std::ifstream stream{file};
  return {std::istreambuf_iterator<char>{stream}, {}};
}

Permissions some_permissions() {
  Permissions permissions;
  allow_publish(permissions, "cmd_vel_user");
  allow_subscribe(permissions, "/joy");
  return permissions;
}

class Keystores : public testing::Test {
 protected:
  Keystores() {
    create_keystore(store, 7);
    create_enclave(store, "/a/b", some_permissions(), 7);
  }
  [[nodiscard]] std::string fault() const { return rt::security_fault(enclave); }
  // Expired an hour ago.
  static Validity past() {
    const std::time_t now = std::time(nullptr);
    return {now - 7200, now - 3600};
  }

  test::TemporaryFolder folder;
  const fs::path store = folder.path() / "keys";
  const fs::path enclave = store / "enclaves/a/b";
};

TEST_F(Keystores, AreLaidOutAsSros2sAndLinkRelatively) {
  for (const char* file :
       {"public/identity_ca.cert.pem", "public/permissions_ca.cert.pem", "enclaves/governance.xml",
        "private/identity_ca.key.pem", "private/permissions_ca.key.pem", "enclaves/governance.p7s"})
    EXPECT_TRUE(fs::is_regular_file(store / file)) << file;
  for (const char* file : {"cert.pem", "key.pem", "permissions.xml", "permissions.p7s"})
    EXPECT_TRUE(fs::is_regular_file(enclave / file)) << file;
  for (const char* file : {"identity_ca.cert.pem", "permissions_ca.cert.pem", "governance.p7s"}) {
    ASSERT_TRUE(fs::is_symlink(enclave / file)) << file;
    EXPECT_TRUE(fs::read_symlink(enclave / file).is_relative()) << file;
  }
  fs::rename(store, folder.path() / "moved");
  EXPECT_EQ(rt::security_fault(folder.path() / "moved/enclaves/a/b"), "");
}

TEST_F(Keystores, KeepKeysFromOthers) {
  for (const auto& key : {store / "private/ca.key.pem", enclave / "key.pem"})
    EXPECT_EQ(fs::status(key).permissions(), fs::perms::owner_read | fs::perms::owner_write) << key;
}

TEST_F(Keystores, CarryKeysOfP256AndTheEnclaveAsTheCertificatesName) {
  const auto certificate = rt::openssl::read_certificate(enclave / "cert.pem");
  const auto authority = rt::openssl::read_certificate(enclave / "identity_ca.cert.pem");
  ASSERT_TRUE(certificate && authority);
  char name[64];
  X509_NAME_get_text_by_NID(X509_get_subject_name(certificate.get()), NID_commonName, name,
                            sizeof name);
  EXPECT_STREQ(name, "/a/b");
  EXPECT_EQ(EVP_PKEY_get_bits(X509_get0_pubkey(certificate.get())), 256);
  EXPECT_EQ(X509_check_ca(authority.get()), 1);
  EXPECT_EQ(X509_check_ca(certificate.get()), 0);
  EXPECT_EQ(fault(), "");
}

TEST_F(Keystores, StayAsTheyAreWhenMadeAgainButForPermissions) {
  const std::string authority = text_in(store / "private/ca.key.pem");
  const std::string key = text_in(enclave / "key.pem");
  const std::string governance = text_in(store / "enclaves/governance.p7s");
  create_keystore(store, 7);
  create_enclave(store, "/a/b", all_permissions(), 7);
  EXPECT_EQ(text_in(store / "private/ca.key.pem"), authority);
  EXPECT_EQ(text_in(enclave / "key.pem"), key);
  EXPECT_EQ(text_in(store / "enclaves/governance.p7s"), governance);
  EXPECT_NE(text_in(enclave / "permissions.xml").find("<topic>rt/*</topic>"), std::string::npos);
  EXPECT_EQ(fault(), "");
}

TEST_F(Keystores, RenewAnExpiredCertificate) {
  create_enclave(store, "/c", some_permissions(), 7, past());
  EXPECT_EQ(rt::security_fault(store / "enclaves/c"), "cert.pem has expired");
  create_enclave(store, "/c", some_permissions(), 7);
  EXPECT_EQ(rt::security_fault(store / "enclaves/c"), "");
}

TEST_F(Keystores, RefuseInvalidEnclaveNames) {
  for (const char* name : {"", "/", "a", "/a/", "/../a", "/a b"})
    EXPECT_THROW(create_enclave(store, name, some_permissions(), 7), std::invalid_argument) << name;
}

TEST_F(Keystores, ReportWhatWasChanged) {
  const auto swap_in_file = [](const fs::path& file, const std::string& from,
                               const std::string& to) {
    std::string text = text_in(file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    std::ofstream{file} << text.replace(at, from.size(), to);
  };
  swap_in_file(enclave / "permissions.p7s", "rt/cmd_vel_user", "rt/cmd_vel");
  EXPECT_TRUE(fault().starts_with("permissions.p7s was changed after it was signed")) << fault();
  create_enclave(store, "/a/b", some_permissions(), 7);
  swap_in_file(store / "enclaves/governance.p7s", "SIGN", "NONE");
  EXPECT_TRUE(fault().starts_with("governance.p7s was changed after it was signed")) << fault();
}

TEST_F(Keystores, ReportAForeignAuthorityKeyOrPermissions) {
  const fs::path other = folder.path() / "other";
  create_keystore(other, 7);
  create_enclave(other, "/a/b", some_permissions(), 7);
  const auto take = [&](const char* file, const fs::path& from) {
    fs::copy_file(from / file, enclave / file, fs::copy_options::overwrite_existing);
  };
  take("cert.pem", other / "enclaves/a/b");
  EXPECT_EQ(fault(), "key.pem is not the key of cert.pem");
  take("key.pem", other / "enclaves/a/b");
  EXPECT_EQ(fault(), "cert.pem was not signed by identity_ca.cert.pem");
  create_enclave(store, "/a/b", some_permissions(), 7);  // replaces the foreign certificate
  EXPECT_EQ(fault(), "");
  create_enclave(store, "/c", some_permissions(), 7);
  take("permissions.p7s", store / "enclaves/c");
  EXPECT_EQ(fault(), "permissions.p7s are not for /a/b, the subject of cert.pem");
}

TEST(PermissionNames, AreThoseOfRos2OnDds) {
  Permissions permissions;
  allow_publish(permissions, "/a/b");
  allow_subscribe(permissions, "c");
  allow_serve(permissions, "/n/s");
  allow_call(permissions, "*");
  EXPECT_EQ(permissions.publish, (std::set<std::string>{"rt/a/b", "rr/n/sReply", "rq/*Request"}));
  EXPECT_EQ(permissions.subscribe, (std::set<std::string>{"rt/c", "rq/n/sRequest", "rr/*Reply"}));
}

TEST(PermissionNames, ThatAPatternCoversAreLeftOutOfTheDocument) {
  Permissions permissions;
  for (const char* topic : {"/a/b", "/a/*", "/a/**", "/ab"}) allow_publish(permissions, topic);
  const std::string text = permissions_document("/e", permissions, usual_validity(), 7);
  int topics = 0;
  for (auto at = text.find("<topic>"); at != std::string::npos; at = text.find("<topic>", at + 1))
    ++topics;
  EXPECT_EQ(topics, 2) << text;
  EXPECT_NE(text.find("<topic>rt/a/*</topic>"), std::string::npos) << text;
  EXPECT_NE(text.find("<topic>rt/ab</topic>"), std::string::npos) << text;
}

TEST(PermissionNames, FollowTheNodesNamespaceAndRemappings) {
  SystemNode node{"teleop", {.name = "stick", .ns = "/r1"}};
  node.options.remappings["cmd_vel_user"] = "/elsewhere";
  const auto permissions = permissions_of(node);
  EXPECT_TRUE(permissions.publish.contains("rt/elsewhere"));
  EXPECT_FALSE(permissions.publish.contains("rt/r1/cmd_vel_user"));
  EXPECT_TRUE(permissions.subscribe.contains("rt/r1/joy"));
  EXPECT_TRUE(permissions.subscribe.contains("rq/r1/stick/set_parametersRequest"));
  EXPECT_TRUE(permissions.publish.contains("ros_discovery_info"));
  EXPECT_TRUE(permissions.publish.contains("rt/rosout"));
}

TEST(PermissionNames, OfAThirdPartysComponentAreThoseThatItDescribes) {
  const auto permissions = permissions_of({"test_component", {.name = "x"}});
  EXPECT_TRUE(permissions.publish.contains("rt/out"));
  EXPECT_TRUE(permissions.subscribe.contains("rt/in"));
  EXPECT_FALSE(permissions.publish.contains("rt/in"));
}

// What the whole is for.
TEST(PermissionNames, OfOurSystemsOnlyTheFilterMayPublishCmdVel) {
  for (const char* file : {"forest", "teleop", "shared_dwa", "hindsight", "live_sensing"}) {
    const auto system =
        load_system(test::source_path("bringup/systems/" + std::string{file} + ".yaml"));
    for (const auto& node : system.nodes)
      EXPECT_EQ(permissions_of(node).publish.contains("rt/cmd_vel"),
                node.component == "safety_filter")
          << file << ": " << node.options.name;
  }
}

}  // namespace
}  // namespace tandem
