// SPDX-License-Identifier: Apache-2.0
// The dashboard of a whole system, and clients of it that are not ours: Python's websockets
// (checks.py), installed by tests/interop/build_peers; skipped where they could not be.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "support/child_process.hpp"
#include "support/instrumented.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 500.0;  // [s] under a sanitizer
const fs::path kPeers = peers_path(), kPython = kPeers / "python" / "bin" / "python";
const std::string kTandem = binary_path("tandem");
const std::string kSystems = source_path("bringup/systems");

std::vector<std::string> client_arguments(const std::string& check) {
  return {source_path("tests/dashboard/checks.py"), kTandem, kSystems + "/teleop.yaml", check};
}

// Two minutes with five clients at a robot of their own, in a domain of its own, beside the other
// clients; judged after the last of these. Under a sanitizer it is some seconds, after all, for
// nothing would be in time beside them.
class Soak : public testing::Environment {
 public:
  void SetUp() override {
    if (kInstrumented)
      setenv("TANDEM_SANITIZED", "1", 1);  // whose memory grows for its own reasons
    else
      begin();
  }
  void TearDown() override {
    if (kInstrumented) begin();
    if (!clients_) return;
    EXPECT_EQ(clients_->wait(kTimeout), 0) << "five clients for a while";
  }

 private:
  void begin() {
    if (!fs::exists(kPython) || GTEST_FLAG_GET(filter) != "*") return;
    const std::string outer = std::getenv("ROS_DOMAIN_ID");
    domain_.emplace();
    clients_.emplace(kPython, client_arguments("soak"));
    setenv("ROS_DOMAIN_ID", outer.c_str(), 1);
  }

  std::optional<PrivateDomain> domain_;
  std::optional<ChildProcess> clients_;
};
[[maybe_unused]] const auto* const kSoak = testing::AddGlobalTestEnvironment(new Soak);

void expect_client_passes(const std::string& check) {
  if (!fs::exists(kPython)) GTEST_SKIP() << kPython << " was not built";
  ChildProcess client{kPython, client_arguments(check)};
  EXPECT_EQ(client.wait(kTimeout), 0);
}

TEST(WebClient, SeesTopicsDrivesAndCallsServices) { expect_client_passes("drive"); }
TEST(WebClient, MaySpeakTheProtocolByTheSdksName) { expect_client_passes("sdk"); }
TEST(WebClient, DrivesAloneUntilAnotherTakesTheWheel) { expect_client_passes("seat"); }
TEST(WebClient, ThatLeavesWithTheStickHeldMustBeSeenAtRestAgain) { expect_client_passes("leave"); }
TEST(WebClient, ThatDrivesHasATrialMeasured) { expect_client_passes("trial"); }
TEST(WebClient, IsRefusedWhereItHasNoAccess) { expect_client_passes("door"); }
TEST(WebClient, NeedsTheTokenIfOthersCanReachTheServer) { expect_client_passes("token"); }
TEST(WebClient, ThatIsHostileChangesNothingForTheRobot) { expect_client_passes("hostile"); }
TEST(WebClient, SeesWhatItCanOfOthersWithOddNamesAndTypes) {
  rt::Node odd{"my__node"};
  const auto text = odd.create_publisher(rt::Topic<std_msgs::msg::String>{"/joy"});
  const auto flag = odd.create_publisher(rt::Topic<std_msgs::msg::Bool>{"/joy"});
  std::vector<rt::Publisher<tf2_msgs::msg::TFMessage>> broadcasters;
  for (int i = 0; i < 3; ++i) {
    tf2_msgs::msg::TFMessage msg;
    msg.transforms().emplace_back();
    msg.transforms()[0].header().frame_id("base_link");
    msg.transforms()[0].child_frame_id("foreign_" + std::to_string(i));
    broadcasters.push_back(odd.create_publisher(topics::tf_static));
    broadcasters.back().publish(msg);
  }
  std::jthread spinning{[&odd] { odd.spin(); }};
  expect_client_passes("foreign");
  odd.stop();
}
// attacks.py by hand presses 200 times and prints the table of components/dashboard/README.md.
TEST(WebClient, StopsTheRobotInTimeBesideFourteenHostileOnes) {
  if (kInstrumented) GTEST_SKIP() << "nothing is in time under a sanitizer";
  if (!fs::exists(kPython)) GTEST_SKIP() << kPython << " was not built";
  ChildProcess attacks{
      kPython,
      {source_path("tests/dashboard/attacks.py"), kTandem, kSystems + "/teleop.yaml", "40"}};
  EXPECT_EQ(attacks.wait(kTimeout), 0);
}
TEST(WebClient, ThatIsSlowIsDropped) { expect_client_passes("slow"); }

}  // namespace
}  // namespace tandem::test
