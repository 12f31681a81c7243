// SPDX-License-Identifier: Apache-2.0
// Checks that the components open exactly the topics that `tandem describe` prints and permissions
// are derived from.
#include "bringup/system/component_topics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "bringup/system/permissions.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/domain_view.hpp"

namespace tandem::test {
namespace {

// "rt/odom" of a subscription or a publisher; services as they are.
std::string dds_name(const rt::DomainEndpoint& endpoint) {
  return endpoint.topic.starts_with('/') ? "rt" + endpoint.topic : endpoint.topic;
}

// A node's endpoints of a type that the first participant has not are in "/_node_2".
bool is_of(const std::string& owner, const std::string& node) {
  return owner == "/" + node || owner == "/_" + node + "_2";
}

Permissions opened_by(const std::string& node, const rt::DomainView& view) {
  Permissions opened;
  for (const auto& endpoint : view.look().endpoints)
    if (is_of(endpoint.node, node))
      (endpoint.writes ? opened.publish : opened.subscribe).insert(dds_name(endpoint));
  return opened;
}

using Names = std::set<std::string>;

Names without(const Names& all, const Names& some) {
  Names rest;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(),
                      std::inserter(rest, rest.begin()));
  return rest;
}

// Endpoints that a component opens only with other parameters or on request.
Names rare_subscriptions(const std::string& component) {
  static const std::map<std::string, Names> all{
      {"driver", {"rt/octomap_binary", "rt/octomap_local", "rt/map"}},  // the adversary
      {"obstacle_extractor", {"rt/map", "rt/people"}},
      {"safety_filter", {"rt/map", "rt/people"}},
      {"shared_dwa", {"rt/map", "rt/octomap_local"}},
      {"hindsight", {"rt/map", "rt/octomap_local"}}};
  const auto found = all.find(component);
  return found == all.end() ? Names{} : found->second;
}

struct Use {
  Permissions opened, granted;
};

// Components by name, over the nodes of all systems.
std::map<std::string, Use> uses_in(const std::string& file) {
  setenv("TANDEM_COMPONENT_PATH", binary_path().c_str(), 0);
  std::map<std::string, Use> uses;
  const auto system = load_system(source_path("bringup/systems/" + file));
  rt::Node watcher{"watcher"};
  const rt::DomainView view{watcher};
  for (const auto& node : system.nodes) {
    auto options = node.options;
    if (node.component == "dashboard") options.parameters.values["port"] = {"0", "test"};
    const rt::RunningComponent component{node.component, options};
    EXPECT_TRUE(spin_until(
        [&] {
          const auto opened = opened_by(options.name, view);
          return opened.publish.contains("rt/parameter_events") && !opened.subscribe.empty();
        },
        10.0, watcher))
        << options.name;
    uses[node.component] = {opened_by(options.name, view), permissions_of(node)};
  }
  return uses;
}

class ComponentTopicsOf : public testing::TestWithParam<const char*> {};

TEST_P(ComponentTopicsOf, AreAllThatTheComponentsOpen) {
  for (const auto& [component, use] : uses_in(GetParam())) {
    if (component == "dashboard") continue;  // it may subscribe to everything
    EXPECT_EQ(without(use.opened.publish, use.granted.publish), Names{}) << component;
    EXPECT_EQ(without(use.opened.subscribe, use.granted.subscribe), Names{}) << component;
  }
}

INSTANTIATE_TEST_SUITE_P(Systems, ComponentTopicsOf,
                         testing::Values("forest.yaml", "teleop.yaml", "shared_dwa.yaml",
                                         "hindsight.yaml", "live_sensing.yaml"),
                         [](const auto& test) {
                           const std::string name = test.param;
                           return name.substr(0, name.find('.'));
                         });

TEST(ComponentTopics, AreNoMoreThanTheComponentsOpen) {
  std::map<std::string, Use> all;
  for (const char* file : {"forest.yaml", "shared_dwa.yaml", "hindsight.yaml", "live_sensing.yaml"})
    for (auto& [component, use] : uses_in(file)) {
      all[component].opened.add(use.opened);
      all[component].granted.add(use.granted);
    }
  ASSERT_EQ(all.size(), 14u);
  // The graph is the process's; the guard opens /diagnostics with the first datagram that it drops;
  // the simulated base keeps real time.
  const Names of_process{"ros_discovery_info", "rt/diagnostics", "rt/clock"};
  for (const auto& [component, use] : all) {
    if (component == "dashboard") continue;
    EXPECT_EQ(without(without(use.granted.publish, use.opened.publish), of_process), Names{})
        << component;
    EXPECT_EQ(without(without(without(use.granted.subscribe, use.opened.subscribe), of_process),
                      rare_subscriptions(component)),
              Names{})
        << component;
  }
}

}  // namespace
}  // namespace tandem::test
