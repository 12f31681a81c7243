// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/diagnoses.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace tandem {
namespace {

namespace fs = std::filesystem;

using rt::DomainEndpoint;
using rt::GraphForm;

// Two ROS 2 processes, one of them this program with a node /tandem that subscribes to /odom
// reliably.
rt::Domain domain() {
  rt::Domain domain;
  domain.participants = {{"aa", true, GraphForm::kSinceIron, {"/tandem"}},
                         {"bb", false, GraphForm::kSinceIron, {"/robot"}}};
  domain.endpoints = {{"aa", "/tandem", "/odom", "nav_msgs/msg/Odometry", false, {1, 0}, "h1"},
                      {"bb", "/robot", "/odom", "nav_msgs/msg/Odometry", true, {1, 0}, "h1"}};
  return domain;
}

bool finds(const std::vector<Finding>& found, const std::string& what) {
  for (const auto& finding : found)
    if (finding.what.find(what) != std::string::npos) return !finding.remedy.empty();
  return false;
}

TEST(Doctor, FindsNothingWhereAllFits) { EXPECT_TRUE(examine(domain()).empty()); }

TEST(Doctor, NamesBothSidesOfQosThatDoesNotFit) {
  auto sick = domain();
  sick.endpoints[1].policies.reliability = 0;
  const auto found = examine(sick);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what,
            "/odom: /robot offers reliability best effort, /tandem requests reliable: no "
            "messages are delivered");
  EXPECT_EQ(found[0].remedy,
            "set qos_overrides./odom.subscription.reliability: best_effort at /tandem, or set "
            "qos_overrides./odom.publisher.reliability: reliable at /robot");
}

TEST(Doctor, AcceptsAMismatchIfASecondSubscriptionMatches) {
  auto well = domain();
  well.endpoints[1].policies.reliability = 0;
  well.endpoints.push_back(
      {"aa", "/tandem", "/odom", "nav_msgs/msg/Odometry", false, {0, 0}, "h1"});
  EXPECT_TRUE(examine(well).empty());
}

TEST(Doctor, FindsTypesAndHashesThatDiffer) {
  auto sick = domain();
  sick.endpoints[1].type_hash = "h2";
  EXPECT_TRUE(finds(examine(sick), "use different versions of nav_msgs/msg/Odometry"));
  sick.endpoints[1].type = "nav_msgs/msg/Path";
  EXPECT_TRUE(finds(examine(sick), "/robot sends nav_msgs/msg/Path, /tandem takes"));
  sick = domain();
  sick.endpoints[1].type_hash.clear();  // Humble tells none
  EXPECT_TRUE(examine(sick).empty());
}

TEST(Doctor, AcceptsTwoTypesIfANodeSubscribesToBoth) {
  auto well = domain();
  well.participants.push_back({"cc", false, GraphForm::kSinceIron, {}});  // of /tandem's process
  well.endpoints.push_back({"cc", "/tandem", "/odom", "nav_msgs/msg/Path", false, {1, 0}, "h3"});
  well.endpoints.push_back({"bb", "/robot", "/odom", "nav_msgs/msg/Path", true, {1, 0}, "h3"});
  EXPECT_TRUE(examine(well).empty());
}

TEST(Doctor, WarnsOfParticipantsOnPortsOfTheNextDomain) {
  auto sick = domain();
  sick.id = 7;
  sick.participants[1].borrows_ports = true;
  EXPECT_TRUE(finds(examine(sick), "1 participant uses UDP ports of domain 8"));
}

TEST(Doctor, FindsDuplicateNodesPlainDdsProgramsAndHumbleBesideOthers) {
  auto sick = domain();
  sick.participants[1].nodes = {"/tandem"};
  EXPECT_TRUE(finds(examine(sick), "2 nodes are called /tandem"));
  sick = domain();
  sick.participants[1].form = GraphForm::kHumble;
  EXPECT_TRUE(finds(examine(sick), "Humble"));
  sick.participants[1] = {"bb", false, GraphForm::kNone, {}};
  EXPECT_TRUE(finds(examine(sick), "announces no nodes"));
  sick = domain();
  sick.malformed = 3;
  EXPECT_TRUE(finds(examine(sick), "3 samples of ros_discovery_info"));
}

TEST(Doctor, FindsOtherPublishersOfCmdVel) {
  auto sick = domain();
  const std::string type = "geometry_msgs/msg/Twist";
  sick.endpoints.push_back({"aa", "/safety_filter", "/a/cmd_vel", type, true, {1, 0}, "h"});
  EXPECT_TRUE(examine(sick).empty());
  sick.endpoints.push_back({"bb", "/robot", "/a/cmd_vel", type, true, {1, 0}, "h"});
  EXPECT_TRUE(finds(examine(sick), "/a/cmd_vel has 2 publishers (/safety_filter, /robot)"));
}

TEST(Doctor, SaysThatNobodyIsThere) {
  auto lonely = domain();
  lonely.participants.pop_back();
  lonely.endpoints.pop_back();
  EXPECT_TRUE(finds(examine(lonely), "no other program"));
}

diagnostic_msgs::msg::DiagnosticArray word(const std::string& name, std::uint8_t level,
                                           const std::string& message,
                                           const std::string& remedy = "") {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.name(name);
  status.level(level);
  status.message(message);
  if (!remedy.empty()) {
    status.values().resize(1);
    status.values()[0].key("remedy");
    status.values()[0].value(remedy);
  }
  diagnostic_msgs::msg::DiagnosticArray msg;
  msg.status().push_back(status);
  return msg;
}

TEST(Doctor, ReportsTheFirstCauseAndRemedyOfAStandingRobot) {
  Diagnoses diagnoses;
  add(diagnoses, word("arbitration", 1, "safety filter: no map yet"));
  add(diagnoses, word("safety_filter", 1, "no map yet", "start a map_server"));
  const auto found = examine(diagnoses);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what, "safety_filter (warning): no map yet");
  EXPECT_EQ(found[0].remedy, "start a map_server");
}

// As word(), of a node that gives one topic and lacks another.
diagnostic_msgs::msg::DiagnosticArray link(const std::string& name, const std::string& message,
                                           const std::string& gives, const std::string& waits_for) {
  auto msg = word(name, 1, message, "mend " + name);
  msg.status()[0].values().resize(3);
  msg.status()[0].values()[1].key("gives");
  msg.status()[0].values()[1].value(gives);
  msg.status()[0].values()[2].key("waits_for");
  msg.status()[0].values()[2].value(waits_for);
  return msg;
}

TEST(Doctor, FollowsWaitingNodesToTheFirstCause) {
  Diagnoses diagnoses;
  add(diagnoses,
      link("local_planner", "obstacles are silent", "/plan /cmd_vel_shared", "/obstacles"));
  add(diagnoses,
      link("obstacle_extractor", "octomap_local is silent", "/obstacles", "/octomap_local"));
  add(diagnoses, link("octomap_builder", "scan is silent", "/octomap_local", ""));
  const auto found = examine(diagnoses);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what, "octomap_builder (warning): scan is silent");
  EXPECT_EQ(found[0].remedy, "mend octomap_builder");
  EXPECT_EQ(first_cause(diagnoses, diagnoses["local_planner"]).name(), "octomap_builder");
}

TEST(Doctor, AHealthyNodeOrAnotherRobotsNodeIsNotACause) {
  Diagnoses diagnoses;
  add(diagnoses, link("a/local_planner", "obstacles are silent", "/a/plan", "/a/obstacles"));
  add(diagnoses, link("b/obstacle_extractor", "no map yet", "/b/obstacles", ""));
  auto well = link("a/obstacle_extractor", "publishing nearby obstacles", "/a/obstacles", "");
  well.status()[0].level(0);
  add(diagnoses, well);
  EXPECT_EQ(first_cause(diagnoses, diagnoses["a/local_planner"]).name(), "a/local_planner");
}

TEST(Doctor, StopsAtACycleOfWaitingNodes) {
  Diagnoses diagnoses;
  add(diagnoses, link("first", "b is silent", "/a", "/b"));
  add(diagnoses, link("second", "a is silent", "/b", "/a"));
  EXPECT_FALSE(first_cause(diagnoses, diagnoses["first"]).name().empty());
}

TEST(Doctor, ReportsOnceWhatSeveralNodesReportOrWasAlreadyFound) {
  Diagnoses diagnoses;
  add(diagnoses, word("obstacle_extractor", 1, "no map yet"));
  add(diagnoses, word("safety_filter", 1, "no map yet"));
  add(diagnoses, word("shared_dwa", 1, "not localized: `odom` is not on /tf"));
  EXPECT_EQ(examine(diagnoses).size(), 2U);
  const std::vector<Finding> found{
      {"the safety filter stops the robot: not localized: `odom` is not on /tf; the frames are "
       "none",
       ""}};
  EXPECT_EQ(examine(diagnoses, found).size(), 1U);
}

TEST(Doctor, ReportsNothingAboutARecoveredNode) {
  Diagnoses diagnoses;
  add(diagnoses, word("safety_filter", 1, "no map yet"));
  add(diagnoses, word("safety_filter", 0, "clear"));
  EXPECT_TRUE(examine(diagnoses).empty());
}

TEST(Doctor, NotesThatNobodySteersWithoutCallingItAProblem) {
  Diagnoses diagnoses;
  add(diagnoses, word("arbitration", 1, "cmd_vel_user is silent"));
  add(diagnoses, word("base driver", 2, "left motor hot"));
  const auto found = examine(diagnoses);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_FALSE(found[0].is_note);
  EXPECT_TRUE(found[1].is_note);
}

TEST(Doctor, PutsErrorsOfForeignNodesFirst) {
  Diagnoses diagnoses;
  add(diagnoses, word("arbitration", 1, "no command"));
  add(diagnoses, word("base driver", 2, "left motor hot"));
  const auto found = examine(diagnoses);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].what, "base driver (error): left motor hot");
  EXPECT_FALSE(found[0].remedy.empty());
}

TEST(Doctor, FindsSegmentsThatNobodyHasMapped) {
  char name[] = "/tmp/tandem_doctor_XXXXXX";
  const fs::path root = mkdtemp(name), shm = root / "shm", proc = root / "proc";
  fs::create_directories(shm);
  fs::create_directories(proc / "12");
  for (const char* file : {"fastrtps_dead", "fastrtps_alive", "other"}) std::ofstream{shm / file};
  std::ofstream{proc / "12" / "maps"} << "7f00-7f01 rw-s 00000000 00:19 5   "
                                      << (shm / "fastrtps_alive").string() << '\n';
  EXPECT_EQ(stale_segments(shm, proc),
            (std::vector<std::string>{(shm / "fastrtps_dead").string()}));
  fs::create_directories(proc / "13");  // whose maps may not be read
  EXPECT_TRUE(stale_segments(shm, proc).empty());
  fs::remove_all(root);
}

}  // namespace
}  // namespace tandem
