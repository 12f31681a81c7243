// SPDX-License-Identifier: Apache-2.0
// The dashboard of a whole system, and people at it who are not ours: Python's websockets
// (client.py) and a real browser (browser/browser_test.mjs). Built by tests/interop/build_peers;
// what could not be is skipped.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "support/private_domain.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 500.0;  // [s] under a sanitizer
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

const fs::path kPeers = TANDEM_PEERS_DIR, kPython = kPeers / "python" / "bin" / "python";
const std::string kTandem = TANDEM_BINARY_DIR "/tandem";
const std::string kSystems = TANDEM_SOURCE_DIR "/bringup/systems";

std::vector<std::string> client_arguments(const std::string& check) {
  return {TANDEM_SOURCE_DIR "/tests/dashboard/client.py", kTandem, kSystems + "/teleop.yaml",
          check};
}

// Two minutes with five clients at a robot of their own, in a domain of its own: they begin after
// the browser, to which a busy machine is a slow one, go on beside the other clients, and are
// judged after the last of these. Under a sanitizer it is some seconds, after all, for nothing
// would be in time beside them.
class Soak : public testing::Environment {
 public:
  void SetUp() override {
    if (kSanitized) setenv("TANDEM_SANITIZED", "1", 1);  // whose memory grows for its own reasons
  }
  void TearDown() override {
    if (kSanitized) begin();
    if (!clients_) return;
    EXPECT_EQ(clients_->wait(kTimeout), 0) << "five clients for a while";
  }
  void begin() {
    if (clients_ || !fs::exists(kPython) || GTEST_FLAG_GET(filter) != "*") return;
    const std::string outer = std::getenv("ROS_DOMAIN_ID");
    domain_.emplace();
    clients_.emplace(kPython, client_arguments("soak"));
    setenv("ROS_DOMAIN_ID", outer.c_str(), 1);
  }

 private:
  std::optional<PrivateDomain> domain_;
  std::optional<ChildProcess> clients_;
};

Soak* soak() {
  static auto* const only = new Soak;
  return only;
}
[[maybe_unused]] const auto* const kSoak = testing::AddGlobalTestEnvironment(soak());

void expect_client_passes(const std::string& check) {
  if (!fs::exists(kPython)) GTEST_SKIP() << kPython << " was not built";
  ChildProcess client{kPython, client_arguments(check)};
  EXPECT_EQ(client.wait(kTimeout), 0);
}

TEST(Browser, DrivesTheRobotAndTakesTheUserTest) {
  if (kSanitized) GTEST_SKIP() << "a browser beside a sanitizer: nothing of it would be in time";
  const fs::path modules = kPeers / "browser", chromium = "/usr/bin/chromium",
                 node = "/usr/bin/node";
  for (const fs::path& needed : {modules / "node_modules", chromium, node})
    if (!fs::exists(needed)) GTEST_SKIP() << "NOT TESTED: there is no " << needed;
  ChildProcess browser{node,
                       {TANDEM_SOURCE_DIR "/tests/dashboard/browser/browser_test.mjs", modules,
                        kTandem, kSystems, chromium}};
  EXPECT_EQ(browser.wait(kTimeout), 0);
}

class WebClient : public testing::Test {
 public:
  static void SetUpTestSuite() {
    if (!kSanitized) soak()->begin();
  }
};

TEST_F(WebClient, SeesTopicsDrivesAndCallsServices) { expect_client_passes("drive"); }
TEST_F(WebClient, DrivesAloneUntilAnotherTakesTheWheel) { expect_client_passes("seat"); }
TEST_F(WebClient, WhoDrivesHasATrialMeasured) { expect_client_passes("trial"); }
TEST_F(WebClient, IsKeptOutWhereItHasNoBusiness) { expect_client_passes("door"); }
TEST_F(WebClient, NeedsTheTokenWhereOthersCanReachTheDoor) { expect_client_passes("token"); }
TEST_F(WebClient, ThatIsHostileChangesNothingForTheRobot) { expect_client_passes("hostile"); }
TEST_F(WebClient, ThatIsSlowIsDropped) { expect_client_passes("slow"); }

}  // namespace
}  // namespace tandem::test
