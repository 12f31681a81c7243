// SPDX-License-Identifier: Apache-2.0
// Tests of a teleoperated robot with peers in other languages: Python on Cyclone DDS, rclpy, and
// Rust on ros2-client. tests/interop/build_peers builds the peers; tests of peers that are missing
// are skipped.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include "bringup/bag/bag.hpp"
#include "support/child_process.hpp"
#include "support/nothing_dropped.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 90.0;  // [s]; the peers give up after 60

const fs::path kPeers = test::peers_path();

const std::string kSystem = test::source_path("bringup/systems/teleop.yaml");

const fs::path kPython = kPeers / "python" / "bin" / "python";
const std::string kScript = test::source_path("tests/interop/python_peer/peer.py");

// Runs the peer with the system as shipped, except for one parameter.
void expect_python_does(const std::string& script, const std::string& check,
                        const std::string& parameter, const fs::path& python = kPython) {
  if (!fs::exists(python)) GTEST_SKIP() << python << " was not built";
  const test::NothingDropped nothing_dropped;
  test::ChildProcess robot{"../tandem", {"run", kSystem, "--ros-args", "-p", parameter}};
  test::ChildProcess peer{python, {script, check}};
  EXPECT_EQ(peer.wait(kTimeout), 0);
  robot.send(SIGTERM);
  EXPECT_EQ(robot.wait(10.0), 0);
}

// With policy manual the peer's Twist passes only the safety filter.
void expect_python_does(const std::string& check) {
  expect_python_does(kScript, check, "arbitration:policy:=manual");
}

TEST(PythonPeer, DrivesOurRobot) { expect_python_does("drive"); }
// The peer's Twist moves the leader, and the planner makes the robot follow it.
TEST(PythonPeer, DrivesByTheLeader) {
  expect_python_does(kScript, "lead", "local_planner:method:=leader");
}
TEST(PythonPeer, DrivesByTheLeadersPath) {
  expect_python_does(kScript, "lead", "local_planner:method:=path");
}
TEST(PythonPeer, SeesOurNodes) { expect_python_does("graph"); }

TEST(PythonPeer, ReadsOurRecordings) {
  if (!fs::exists(kPython)) GTEST_SKIP() << kPython << " was not built";
  char name[] = "/tmp/tandem_peers_XXXXXX";
  const fs::path root = mkdtemp(name), folder = root / "drive";
  {
    BagWriter writer{folder};
    const int topic = writer.add_topic({"/numbers", "std_msgs/msg/Float64"});
    for (int i = 0; i < 10; ++i) {
      const double number = i;
      std::vector<std::uint8_t> bytes(4 + sizeof number);
      bytes[1] = 1;  // little endian
      std::memcpy(bytes.data() + 4, &number, sizeof number);
      writer.write(topic, 1'000'000 * (i + 1), bytes);
    }
  }
  test::ChildProcess peer{kPython, {kScript, "bag", folder}};
  EXPECT_EQ(peer.wait(kTimeout), 0);
  fs::remove_all(root);
}

// rclpy, ROS 2's Python library, of a release of ROS 2.
const std::string kUserScript = test::source_path("tests/interop/rclpy/user_script.py");

// Newer releases of ROS 2 no longer support ROS_LOCALHOST_ONLY.
class RclpyScript : public testing::TestWithParam<const char*> {
 protected:
  RclpyScript() {
    unsetenv("ROS_LOCALHOST_ONLY");
    setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  }
  ~RclpyScript() override {
    unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
    setenv("ROS_LOCALHOST_ONLY", "1", 1);
  }
  fs::path python_ = kPeers / (std::string{"rclpy_"} + GetParam()) / "bin" / "python";
};

TEST_P(RclpyScript, DrivesByTheLeader) {
  expect_python_does(kUserScript, "", "local_planner:method:=leader", python_);
}
TEST_P(RclpyScript, DrivesByTheLeadersPath) {
  expect_python_does(kUserScript, "", "local_planner:method:=path", python_);
}

INSTANTIATE_TEST_SUITE_P(Releases, RclpyScript, testing::Values("jazzy", "kilted"),
                         [](const auto& release) { return std::string{release.param}; });

const fs::path kRust = kPeers / "rust" / "rust_peer";

void expect_rust_does(const std::string& check) {
  if (!fs::exists(kRust)) GTEST_SKIP() << kRust << " was not built";
  constexpr int kNoNamespace = 77;
  const test::NothingDropped nothing_dropped;
  test::ChildProcess both{test::source_path("tests/interop/rust_peer/beside_robot"),
                          {test::binary_path("tandem"), kSystem, kRust, check}};
  const auto status = both.wait(kTimeout);
  if (status == kNoNamespace) GTEST_SKIP() << "no network namespace can be made here";
  EXPECT_EQ(status, 0);
}

TEST(RustPeer, SeesOurNodes) { expect_rust_does("graph"); }
TEST(RustPeer, DrivesOurRobot) { expect_rust_does("topics"); }
TEST(RustPeer, CallsOurServices) { expect_rust_does("services"); }
TEST(RustPeer, ListsGetsAndSetsOurParameters) { expect_rust_does("parameters"); }
TEST(RustPeer, GetsNoAnswerInTheOtherConvention) { expect_rust_does("foreign_convention"); }

}  // namespace
}  // namespace tandem
