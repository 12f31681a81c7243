// SPDX-License-Identifier: Apache-2.0
// The files of bringup/views: what they show must be what the components describe.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/paths.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/every_node.hpp"

namespace tandem {
namespace {

using nlohmann::json;

struct Described {
  std::string type;
  rt::Policies policies;
};
using Topics = std::multimap<std::string, Described>;

std::string absolute(const std::string& component, const std::string& name) {
  if (name.starts_with("~/")) return "/" + component + name.substr(1);
  return name.starts_with("/") ? name : "/" + name;
}

// What all components together publish, subscribe to and serve.
struct Graph {
  Graph() {
    for (const auto& component : rt::list_components()) {
      add(component, rt::description_of(component).interface);
      add(component, rt::every_node::interface());
    }
  }
  void add(const std::string& component, const rt::Interface& interface) {
    for (const auto& use : interface.publishes)
      published.insert({absolute(component, use.name), {use.type, policies_of(use.qos)}});
    for (const auto& use : interface.subscribes)
      subscribed.insert({absolute(component, use.name), {use.type, policies_of(use.qos)}});
    for (const auto& use : interface.serves) services.insert(absolute(component, use.name));
  }

  Topics published, subscribed;
  std::set<std::string> services;
};

const Graph& graph() {
  static const Graph all;
  return all;
}

bool has(const Topics& topics, const std::string& name, const std::string& type) {
  const auto [begin, end] = topics.equal_range(name);
  return std::any_of(begin, end, [&](const auto& topic) { return topic.second.type == type; });
}

// --- RViz

// The type of the messages that an RViz display or tool takes or sends.
const std::map<std::string, std::string> kRvizTypes{
    {"Map", "nav_msgs/msg/OccupancyGrid"},
    {"MarkerArray", "visualization_msgs/msg/MarkerArray"},
    {"LaserScan", "sensor_msgs/msg/LaserScan"},
    {"Path", "nav_msgs/msg/Path"},
    {"Odometry", "nav_msgs/msg/Odometry"},
    {"RobotModel", "std_msgs/msg/String"},
    {"SetInitialPose", "geometry_msgs/msg/PoseWithCovarianceStamped"},
    {"SetGoal", "geometry_msgs/msg/PoseStamped"}};
const std::set<std::string> kWithoutTopic{"Grid", "TF", "MoveCamera", "Measure"};

rt::Policies policies_in(const YAML::Node& topic) {
  return {.reliability = topic["Reliability Policy"].as<std::string>() == "Reliable" ? 1 : 0,
          .durability = topic["Durability Policy"].as<std::string>() == "Transient Local" ? 1 : 0};
}

// Calls `check(class, name, policies)` for each display or tool of the list; returns how many have
// a topic.
int for_each_topic(
    const YAML::Node& list,
    const std::function<void(const std::string&, const std::string&, const rt::Policies&)>& check) {
  int topics = 0;
  for (const auto& entry : list) {
    const auto whole = entry["Class"].as<std::string>();
    const std::string kind = whole.substr(whole.find('/') + 1);
    const YAML::Node topic = entry["Topic"] ? entry["Topic"] : entry["Description Topic"];
    EXPECT_EQ(!topic.IsDefined(), kWithoutTopic.contains(kind)) << whole;
    if (!topic) continue;
    check(kind, topic["Value"].as<std::string>(), policies_in(topic));
    ++topics;
  }
  return topics;
}

TEST(Views, OfRvizShowWhatIsPublishedAndSendWhatIsSubscribedTo) {
  const YAML::Node rviz = YAML::LoadFile(test::source_path("bringup/views/tandem.rviz"));
  const YAML::Node manager = rviz["Visualization Manager"];
  EXPECT_EQ(manager["Global Options"]["Fixed Frame"].as<std::string>(), "map");
  const int shown = for_each_topic(
      manager["Displays"], [](const auto& kind, const auto& name, const auto& asked) {
        ASSERT_TRUE(has(graph().published, name, kRvizTypes.at(kind))) << kind << " " << name;
        for (auto [topic, end] = graph().published.equal_range(name); topic != end; ++topic)
          EXPECT_TRUE(rt::qos_mismatches(topic->second.policies, asked).empty()) << name;
      });
  EXPECT_GE(shown, 7);
  const int sent =
      for_each_topic(manager["Tools"], [](const auto& kind, const auto& name, const auto&) {
        EXPECT_TRUE(has(graph().subscribed, name, kRvizTypes.at(kind))) << kind << " " << name;
      });
  EXPECT_EQ(sent, 2);
}

// --- Foxglove and Lichtblick

json foxglove() {
  std::ifstream file{test::source_path("bringup/views/tandem_foxglove.json")};
  return json::parse(file);
}

void collect_panels(const json& tree, std::set<std::string>& panels) {
  if (tree.is_string()) {
    panels.insert(tree.get<std::string>());
    return;
  }
  EXPECT_TRUE(tree.at("direction") == "row" || tree.at("direction") == "column");
  for (const char* child : {"first", "second"}) collect_panels(tree.at(child), panels);
}

// "/odom" of "/odom.twist.twist.linear.x".
std::string topic_in(const std::string& path) { return path.substr(0, path.find('.')); }

TEST(Views, OfFoxgloveHaveAConfigurationForEachPanel) {
  const json layout = foxglove();
  std::set<std::string> panels, configured;
  collect_panels(layout.at("layout"), panels);
  for (const auto& [panel, config] : layout.at("configById").items()) configured.insert(panel);
  EXPECT_EQ(panels, configured);
}

TEST(Views, OfFoxgloveShowWhatIsPublished) {
  const json panels = foxglove().at("configById");
  std::vector<std::string> shown{panels.at("3D!view").at("layers").at("robot").at("topic"),
                                 panels.at("DiagnosticSummary!health").at("topicToRender")};
  for (const auto& [topic, options] : panels.at("3D!view").at("topics").items())
    shown.push_back(topic);
  for (const auto& path : panels.at("Plot!speed").at("paths"))
    shown.push_back(topic_in(path.at("value")));
  for (const char* panel : {"RawMessages!why", "RawMessages!remedy"})
    shown.push_back(topic_in(panels.at(panel).at("topicPath")));
  for (const auto& topic : shown) EXPECT_TRUE(graph().published.contains(topic)) << topic;
}

TEST(Views, OfFoxgloveSendWhatIsSubscribedTo) {
  const json panels = foxglove().at("configById");
  const json& publish = panels.at("3D!view").at("publish");
  EXPECT_TRUE(has(graph().subscribed, publish.at("poseTopic"), "geometry_msgs/msg/PoseStamped"));
  EXPECT_TRUE(has(graph().subscribed, publish.at("poseEstimateTopic"),
                  "geometry_msgs/msg/PoseWithCovarianceStamped"));
  const json& teleop = panels.at("Teleop!drive");
  EXPECT_TRUE(has(graph().subscribed, teleop.at("topic"), "geometry_msgs/msg/Twist"));
  EXPECT_GE(teleop.at("publishRate"), 20);  // arbitration's user_timeout is 0.11 s
  for (const char* panel : {"Publish!stop", "Publish!unstop"}) {
    const json& button = panels.at(panel);
    EXPECT_TRUE(has(graph().subscribed, button.at("topicName"), button.at("datatype")));
    EXPECT_TRUE(json::parse(button.at("value").get<std::string>()).at("data").is_boolean());
  }
  EXPECT_TRUE(graph().services.contains(panels.at("CallService!release").at("serviceName")));
}

}  // namespace
}  // namespace tandem
