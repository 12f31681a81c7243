// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "support/private_domain.hpp"
#include "tandem/runtime/arguments.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/parameter_files.hpp"

namespace tandem {
namespace {

struct Limits {
  double a_max = 0.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("a_max", a_max, Range{0.0, 2.0}, "[m/s²] limit");
  }
};

struct GateParams {
  double margin = 0.1;
  int steps = 5;
  bool enforce = true;
  std::string mode = "shared";
  std::string map = "";
  std::vector<double> outline;
  std::vector<std::string> sensors{"scan"};
  double wheel_radius = 0.1;
  Limits limits;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("margin", margin, Range{0.0, 1.0}, "[m] gap");
    field("steps", steps, Range{1, 50}, "how many");
    field("enforce", enforce, "whether");
    field("mode", mode, OneOf{{"manual", "shared"}}, "who drives");
    field("map", map, "file");
    field("outline", outline, Range{-5.0, 5.0}, "[m]");
    field("sensors", sensors, OneOf{{"scan", "cloud"}}, "which");
    field("wheels.left.radius", wheel_radius, Range{0.0, 1.0}, "[m]");
    limits.visit(field);
  }
};

// Loads `yaml` as a parameter file of node /gate and returns the error message, or "".
class ParameterFile : public testing::Test {
 protected:
  std::string load(const std::string& yaml) {
    std::ofstream{path_} << yaml;
    try {
      rt::ParameterStore store{"/gate", {.files = {path_}}};
      params_ = {};
      params_.visit(store);
      store.check_unknown();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  void expect_complaint(const std::string& yaml, const std::vector<std::string>& parts) {
    const std::string text = load(yaml);
    EXPECT_FALSE(text.empty()) << "accepted:\n" << yaml;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
  }

  std::string path_ = testing::TempDir() + "parameters_" + std::to_string(getpid()) + ".yaml";
  GateParams params_;
};

TEST_F(ParameterFile, AListOfTextsIsReadAndEachIsChecked) {
  const std::string head = "gate:\n  ros__parameters:\n    sensors: ";
  EXPECT_EQ(load(head + "[cloud, \"scan\"]\n"), "");
  EXPECT_EQ(params_.sensors, (std::vector<std::string>{"cloud", "scan"}));
  EXPECT_EQ(load(head + "[]\n"), "");
  EXPECT_TRUE(params_.sensors.empty());
  expect_complaint(head + "[scan, sonar]\n", {"sensors", "'sonar'", "scan, cloud"});
  expect_complaint(head + "scan\n", {"sensors", "a list of strings"});
  expect_complaint(head + "[1.0]\n", {"sensors", "a list of strings"});
}

TEST_F(ParameterFile, GivesEveryKindOfValue) {
  ASSERT_EQ(load("gate:\n  ros__parameters:\n    margin: 0.25\n    steps: 7\n    enforce: false\n"
                 "    mode: manual\n    map: \"7\"\n    outline: [1, -2.5]\n    a_max: 1\n"),
            "");
  EXPECT_EQ(params_.margin, 0.25);
  EXPECT_EQ(params_.steps, 7);
  EXPECT_FALSE(params_.enforce);
  EXPECT_EQ(params_.mode, "manual");
  EXPECT_EQ(params_.map, "7");
  EXPECT_EQ(params_.outline, (std::vector<double>{1.0, -2.5}));
  EXPECT_EQ(params_.limits.a_max, 1.0);  // an integer will do for a number
}

// As rcl of Lyrical reads them.
TEST_F(ParameterFile, MayHaveTheTagsOfYaml) {
  ASSERT_EQ(load("gate:\n  ros__parameters:\n    margin: !!float 1\n    steps: !!int 7\n"
                 "    enforce: !!bool false\n    map: !!str 7\n    outline: [!!float 1, -2.5]\n"),
            "");
  EXPECT_EQ(params_.margin, 1.0);
  EXPECT_EQ(params_.steps, 7);
  EXPECT_FALSE(params_.enforce);
  EXPECT_EQ(params_.map, "7");
  EXPECT_EQ(params_.outline, (std::vector<double>{1.0, -2.5}));
  expect_complaint("gate:\n  ros__parameters:\n    steps: !!float 7\n", {path_ + ":3", "steps"});
}

// The output format of `ros2 param dump /gate`: keys split at dots, sorted, with PyYAML's quotes.
TEST_F(ParameterFile, IsWhatRos2ParamDumpWrites) {
  ASSERT_EQ(load("/gate:\n  ros__parameters:\n    a_max: 1.0e-05\n    enforce: false\n"
                 "    map: '7'\n    margin: 0.25\n    mode: manual\n    outline: []\n"
                 "    steps: 7\n    wheels:\n      left:\n        radius: 0.5\n"),
            "");
  EXPECT_EQ(params_.limits.a_max, 1e-5);
  EXPECT_EQ(params_.map, "7");
  EXPECT_TRUE(params_.outline.empty());
  EXPECT_EQ(params_.wheel_radius, 0.5);
}

TEST_F(ParameterFile, KeepsDefaultsOfUnsetParameters) {
  ASSERT_EQ(load("gate:\n  ros__parameters:\n"), "");
  EXPECT_EQ(params_.margin, 0.1);
}

TEST_F(ParameterFile, OwnSectionWinsOverWildcard) {
  ASSERT_EQ(load("gate:\n  ros__parameters: {margin: 0.3}\n/**:\n  ros__parameters: {margin: 0.2, "
                 "steps: 9}\n"),
            "");
  EXPECT_EQ(params_.margin, 0.3);
  EXPECT_EQ(params_.steps, 9);
}

TEST_F(ParameterFile, OfOtherNodesIsIgnored) {
  EXPECT_EQ(load("other:\n  ros__parameters: {nonsense: 1}\n/a/gate:\n  ros__parameters: {x: 1}\n"),
            "");
}

TEST_F(ParameterFile, UnknownKeyIsNamedWithFileAndLine) {
  expect_complaint("gate:\n  ros__parameters:\n    margn: 0.2\n", {path_ + ":3", "margn", "/gate"});
}

TEST_F(ParameterFile, UnknownWildcardKeyIsReportedAsUnused) {
  EXPECT_EQ(load("/**:\n  ros__parameters:\n    margn: 0.2\n    margin: 0.2\n"), "");
  const auto unused = rt::unused_wildcard_keys();
  EXPECT_EQ(std::count(unused.begin(), unused.end(), path_ + ":3: margn"), 1);
  EXPECT_EQ(std::count(unused.begin(), unused.end(), path_ + ":4: margin"), 0);
}

TEST_F(ParameterFile, TheLaterOfTwoWildcardSectionsWinsAndTheFirstIsNotReportedAsUnused) {
  EXPECT_EQ(load("/**:\n  ros__parameters: {margin: 0.3}\n/**:\n  ros__parameters:\n"
                 "    margin: 0.2\n"),
            "");
  EXPECT_EQ(params_.margin, 0.2);
  const auto unused = rt::unused_wildcard_keys();
  EXPECT_EQ(std::count(unused.begin(), unused.end(), path_ + ":2: margin"), 0);
}

TEST_F(ParameterFile, RefusesAnEmptyFileOrAFolder) {
  expect_complaint("", {path_, "is empty"});
  expect_complaint("# nothing left\n", {path_, "is empty"});
  EXPECT_THROW(rt::ParameterStore("/gate", {.files = {"/tmp"}}), std::invalid_argument);
}

TEST_F(ParameterFile, ThatIsAUrdfIsRefusedWithTheCommandThatReadsIt) {
  try {
    const rt::ParameterStore store{"/gate", {.files = {"trolley.urdf"}}};
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("tandem robot trolley.urdf > robot.yaml"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(ParameterFile, WithAliasesWithoutEndIsRefused) {
  expect_complaint("/**:\n  ros__parameters: {x: &b {y: *b}}\n", {path_ + ":2", "alias"});
  expect_complaint("/**: &a\n  ros__parameters: {x: [*a]}\n", {path_, "alias"});
  std::string bomb = "/**:\n  ros__parameters:\n    a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "    a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int j = 1; j < 10; ++j) bomb += ", " + before;
    bomb += "]\n";
  }
  expect_complaint(bomb, {path_, "million"});
}

TEST_F(ParameterFile, WithASecondDocumentIsRefused) {
  const std::string first = "---\n/**:\n  ros__parameters: {margin: 0.1}\n";
  expect_complaint(first + "---\n/**:\n  ros__parameters: {margin: 0.2}\n",
                   {path_ + ":5", "second document"});
  expect_complaint(first + "---\n---\n/**:\n  ros__parameters: {margin: 0.2}\n",
                   {path_ + ":6", "second document"});
}

TEST_F(ParameterFile, ReportsSectionsForMissingNodes) {
  std::ofstream{path_} << "/**:\n  ros__parameters: {a: 1}\ngate:\n  ros__parameters: {b: 1}\n"
                          "/gaet:\n  ros__parameters: {margin: 0.1}\n";
  const auto strangers = rt::sections_for_nobody(path_, {"/gate", "/other"});
  ASSERT_EQ(strangers.size(), 1U);
  EXPECT_EQ(strangers[0].name, "/gaet");
  EXPECT_EQ(strangers[0].origin, path_ + ":6");
}

TEST_F(ParameterFile, ReportsAMisspeltNodeUnderAWildcard) {
  std::ofstream{path_} << "/**:\n  telleop:\n    ros__parameters: {leash: 0.3}\n"
                          "  teleop:\n    ros__parameters: {leash: 0.3}\n"
                          "/a/*:\n  ros__parameters: {b: 1}\n";
  const auto strangers = rt::sections_for_nobody(path_, {"/teleop", "/b/teleop"});
  ASSERT_EQ(strangers.size(), 2U);
  EXPECT_EQ(strangers[0].name, "/**/telleop");
  EXPECT_EQ(strangers[1].name, "/a/*");
}

// Falling back to a default instead of the value in the file would configure a different robot.
TEST_F(ParameterFile, ARetiredNameIsRefusedWithTheNewOnes) {
  for (const std::string node : {"gate", "/**"}) {
    expect_complaint(node + ":\n  ros__parameters:\n    command_timeout: 0.6\n",
                     {path_ + ":3", "command_timeout = 0.6", "base_timeout", "arbitrated_timeout",
                      "in_force_timeout"});
  }
}

TEST_F(ParameterFile, ValueOutOfBoundsIsNamedWithItsBound) {
  const std::string head = "gate:\n  ros__parameters:\n    ";
  expect_complaint(head + "margin: 1.5\n", {path_ + ":3", "margin", "1.5", "[0, 1]"});
  expect_complaint(head + "margin: .nan\n", {"margin", "[0, 1]"});
  expect_complaint(head + "steps: 0\n", {"steps", "0", "[1, 50]"});
  expect_complaint(head + "mode: auto\n", {"mode", "auto", "manual, shared"});
  expect_complaint(head + "outline: [0, 9]\n", {"outline", "9", "[-5, 5]"});
  expect_complaint(head + "a_max: 3\n", {"a_max", "[0, 2]"});
}

TEST_F(ParameterFile, ValueOfAWrongTypeIsNamed) {
  const std::string head = "gate:\n  ros__parameters:\n    ";
  expect_complaint(head + "margin: \"0.5\"\n", {"margin", "\"0.5\"", "a number"});
  expect_complaint(head + "margin: wide\n", {"margin", "wide", "a number"});
  expect_complaint(head + "margin: [1]\n", {"margin", "a number"});
  expect_complaint(head + "steps: 2.5\n", {"steps", "2.5", "an integer"});
  expect_complaint(head + "enforce: 1\n", {"enforce", "true or false"});
  expect_complaint(head + "mode: 1\n", {"mode", "a string"});
  expect_complaint(head + "outline: [1, two]\n", {"outline", "list of numbers"});
  expect_complaint(head + "outline: [\"1\"]\n", {"outline", "list of numbers"});
}

TEST_F(ParameterFile, RefusesFilesNotInRos2sForm) {
  expect_complaint("gate: 5\n", {path_ + ":1"});
  expect_complaint("ros__parameters: {margin: 0.1}\n", {path_ + ":1", "ros__parameters"});
  expect_complaint("gate: [\n", {path_});
  expect_complaint("[a]: 1\n", {path_ + ":1"});
  expect_complaint("gate:\n  ros__parameters:\n    margin: 0.1\n    margin: 0.2\n", {"twice"});
}

TEST(ParameterStore, NamesAMissingFile) {
  EXPECT_THROW(rt::ParameterStore("/gate", {.files = {"/nowhere.yaml"}}), std::invalid_argument);
}

TEST(RosArguments, ChangeNameRemappingsAndParameters) {
  const auto arguments = rt::parse_ros_arguments(
      {"--here", "--ros-args", "-r", "cmd_vel:=/wheels", "-r", "__node:=left", "-r", "__ns:=/a",
       "-p", "margin:=0.4", "-p", "other:steps:=3", "--", "--there"});
  EXPECT_EQ(arguments.rest, (std::vector<std::string>{"--here", "--there"}));
  const auto options = rt::with_arguments({.name = "gate"}, arguments);
  EXPECT_EQ(options.name, "left");
  EXPECT_EQ(options.ns, "/a");
  EXPECT_EQ(options.remappings.at("cmd_vel"), "/wheels");
  EXPECT_FALSE(options.parameters.overrides.contains("steps"));
  rt::Node node{options};
  EXPECT_EQ(node.declare_parameters<GateParams>()->margin, 0.4);
  EXPECT_NO_THROW(node.check_parameters());
}

TEST(RosArguments, ReportMissingNodes) {
  const auto arguments = rt::parse_ros_arguments(
      {"--ros-args", "-r", "gate:__node:=left", "-p", "left:margin:=0.4", "-p", "gate:margin:=0.5",
       "-r", "left:x:=y", "-p", "nobody:x:=1", "-p", "margin:=0.4"});
  EXPECT_EQ(rt::strangers_in(arguments, {{.name = "gate"}, {.name = "other"}}),
            (std::vector<std::string>{"left", "nobody"}));
}

// The arguments that launch files pass.
TEST(RosArguments, AcceptWhatRos2Accepts) {
  const auto arguments = rt::parse_ros_arguments(
      {"--ros-args", "--log-level", "a.gate:=DEBUG", "--log-level", "other:=fatal",
       "--disable-rosout-logs", "--enable-stdout-logs", "--disable-external-lib-logs", "--enclave",
       "/x", "--log-config-file", "y", "-r", "out:={node}/{ns}/x"});
  const auto gate = rt::with_arguments({.name = "gate", .ns = "/a"}, arguments);
  EXPECT_EQ(gate.log_level, rt::LogLevel::kDebug);
  EXPECT_FALSE(gate.logs_to_rosout);
  EXPECT_EQ(rt::with_arguments({.name = "other"}, arguments).log_level, rt::LogLevel::kOff);
  EXPECT_FALSE(rt::with_arguments({.name = "third"}, arguments).log_level);
  EXPECT_EQ(rt::resolve_name("out", rt::NodeName{"/a", "gate"}, {{"out", "/{node}{ns}/x"}}),
            "/gate/a/x");
  EXPECT_THROW((void)rt::parse_ros_arguments({"--ros-args", "--enable-x-logs"}),
               std::invalid_argument);
  EXPECT_THROW((void)rt::parse_ros_arguments({"--ros-args", "--log-level", "a:=loud"}),
               std::invalid_argument);
}

// A plain -p applies to every node that has the parameter, as in rcl. One that names a node must
// name a parameter of that node.
TEST(RosArguments, APlainParameterMayBeAnothersNodes) {
  const auto plain = rt::parse_ros_arguments({"--ros-args", "-p", "margn:=0.4"});
  {
    rt::Node node{rt::with_arguments({.name = "gate"}, plain)};
    (void)node.declare_parameters<GateParams>();
    EXPECT_NO_THROW(node.check_parameters());
  }
  const auto unused = rt::unused_wildcard_keys();
  EXPECT_NE(std::find(unused.begin(), unused.end(), "command line: margn"), unused.end());
  const auto own = rt::parse_ros_arguments({"--ros-args", "-p", "gate:margn:=0.4"});
  rt::Node strict{rt::with_arguments({.name = "gate"}, own)};
  (void)strict.declare_parameters<GateParams>();
  EXPECT_THROW(strict.check_parameters(), std::invalid_argument);
}

TEST(RosArguments, RefuseWhatRos2Refuses) {
  EXPECT_THROW((void)rt::parse_ros_arguments({"--ros-args", "-r"}), std::invalid_argument);
  EXPECT_THROW((void)rt::parse_ros_arguments({"--ros-args", "-p", "x=1"}), std::invalid_argument);
  EXPECT_THROW((void)rt::parse_ros_arguments({"--ros-args", "x"}), std::invalid_argument);
}

TEST(Names, ExpandAsRos2Does) {
  const auto node = rt::make_node_name("/a/b", "n");
  EXPECT_EQ(rt::expand_name("x/y", node), "/a/b/x/y");
  EXPECT_EQ(rt::expand_name("/x", node), "/x");
  EXPECT_EQ(rt::expand_name("~/x", node), "/a/b/n/x");
  EXPECT_EQ(rt::resolve_name("x", node, {{"/a/b/x", "~/z"}}), "/a/b/n/z");
  EXPECT_EQ(rt::expand_name("a__b", rt::NodeName{"/", "gate"}), "/a__b");
  for (const char* bad : {"", "/", "a//b", "a/", "1a", "a b", "ä", "~x", "a-b"})
    EXPECT_THROW((void)rt::expand_name(bad, node), std::invalid_argument) << bad;
  EXPECT_NO_THROW((void)rt::make_node_name("/" + std::string(244, 'a'), std::string(255, 'a')));
  EXPECT_THROW((void)rt::make_node_name("/", std::string(256, 'a')), std::invalid_argument);
  EXPECT_THROW((void)rt::make_node_name(std::string(245, 'a'), "n"), std::invalid_argument);
  EXPECT_NO_THROW((void)rt::expand_name("/" + std::string(246, 'a'), node));
  EXPECT_THROW((void)rt::expand_name("/" + std::string(247, 'a'), node), std::invalid_argument);
  EXPECT_THROW((void)rt::make_node_name("/", "a b"), std::invalid_argument);
  EXPECT_THROW((void)rt::make_node_name("/a//b", "n"), std::invalid_argument);
}

TEST(Names, MangleAsRmwDoes) {
  EXPECT_EQ(rt::dds_topic_name("/ns/cmd_vel"), "rt/ns/cmd_vel");
  EXPECT_EQ(rt::dds_request_name("/ns/trig"), "rq/ns/trigRequest");
  EXPECT_EQ(rt::dds_reply_name("/ns/trig"), "rr/ns/trigReply");
}

TEST(Environment, AnInvalidDomainIsRefused) {
  const std::string domain = getenv("ROS_DOMAIN_ID");
  for (const char* bad : {"-1", "233", "x", "1x", "99999999999"}) {
    setenv("ROS_DOMAIN_ID", bad, 1);
    EXPECT_THROW(rt::Node{"nowhere"}, std::exception) << bad;
  }
  setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
}

}  // namespace
}  // namespace tandem
