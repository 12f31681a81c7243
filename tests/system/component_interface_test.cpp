// SPDX-License-Identifier: Apache-2.0
// Checks that each component opens exactly the topics and services that it describes, with the
// same types, reliability and durability.
#include <gtest/gtest.h>

#include <algorithm>
#include <compare>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/domain_view.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::test {
namespace {

// An endpoint as DDS announces it; services by their DDS names.
struct Opened {
  std::string topic, type;
  bool writes;
  rt::Reliability reliability;
  rt::Durability durability;

  auto operator<=>(const Opened&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Opened& endpoint) {
  return out << (endpoint.writes ? "publishes " : "subscribes to ") << endpoint.topic << ", "
             << endpoint.type << ", "
             << to_text(rt::QoS{endpoint.reliability, endpoint.durability});
}

struct Described : Opened {
  std::string condition{};
  bool or_weaker = false;
};

// What a component describes, under the names that a node has.
struct Description {
  std::vector<Described> endpoints;
  bool subscribes_to_all = false, calls_all = false;
};

class Describer {
 public:
  explicit Describer(const SystemNode& node) : options_{node.options} {
    add(rt::description_of(node.component).interface);
    add(rt::every_node::interface());
  }
  Description description;

 private:
  void add(const rt::Interface& all) {
    for (const auto& use : all.publishes) add(use, true);
    for (const auto& use : all.subscribes) add(use, false);
    for (const auto& use : all.serves) add(use);
    for (const auto& use : all.serves_actions) add(use);
    EXPECT_TRUE(all.calls_actions.empty()) << "not tested";
    for (const auto& use : all.calls) {
      EXPECT_EQ(use.name, "*") << "not tested";
      description.calls_all = true;
    }
  }

  void add(const rt::TopicUse& use, bool writes) {
    if (use.name == "*")
      description.subscribes_to_all = true;
    else
      add({{rt::ros_name(rt::dds_topic_name(resolved(use.name))), use.type, writes,
            use.qos.reliability, use.qos.durability},
           use.condition,
           use.accepts == rt::Accepts::kEvery});
  }

  void add(const rt::ServiceUse& use) {
    add_service(resolved(use.name), use.type, use.qos, use.condition);
  }

  void add(const rt::ActionUse& use) {
    const rt::ActionParts parts = rt::parts_of(resolved(use.name));
    add_service(parts.send_goal, use.type + "_SendGoal", rt::kServices, use.condition);
    add_service(parts.cancel_goal, "action_msgs/srv/CancelGoal", rt::kServices, use.condition);
    add_service(parts.get_result, use.type + "_GetResult", rt::kServices, use.condition);
    add_topic(parts.feedback, use.type + "_FeedbackMessage", rt::kDefault, use.condition);
    add_topic(parts.status, "action_msgs/msg/GoalStatusArray", rt::kActionStatus, use.condition);
  }

  void add_service(const std::string& name, const std::string& type, const rt::QoS& qos,
                   const std::string& condition) {
    add({{rt::dds_request_name(name), type + "_Request", false, qos.reliability, qos.durability},
         condition});
    add({{rt::dds_reply_name(name), type + "_Response", true, qos.reliability, qos.durability},
         condition});
  }

  void add_topic(const std::string& name, const std::string& type, const rt::QoS& qos,
                 const std::string& condition) {
    add({{name, type, true, qos.reliability, qos.durability}, condition});
  }

  void add(Described endpoint) { description.endpoints.push_back(std::move(endpoint)); }

  [[nodiscard]] std::string resolved(const std::string& name) const {
    return rt::resolve_name(name, rt::make_node_name(options_.ns, options_.name),
                            options_.remappings);
  }

  const rt::NodeOptions& options_;
};

// A node's endpoints of a type that the first participant has not are in "/_node_2".
bool is_of(const std::string& owner, const std::string& node) {
  return owner == "/" + node || owner == "/_" + node + "_2";
}

std::set<Opened> opened_by(const std::string& node, const rt::DomainView& view) {
  std::set<Opened> opened;
  for (const auto& endpoint : view.look().endpoints)
    if (is_of(endpoint.node, node) && endpoint.topic != "ros_discovery_info")
      opened.insert({endpoint.topic, endpoint.type, endpoint.writes,
                     static_cast<rt::Reliability>(endpoint.policies.reliability),
                     static_cast<rt::Durability>(endpoint.policies.durability)});
  return opened;
}

// What is known of each participant, for the message of a failure.
std::string participants_in(const rt::DomainView& view) {
  const rt::Domain domain = view.look();
  std::string text;
  for (const auto& participant : domain.participants) {
    int endpoints = 0, of_nodes = 0;
    for (const auto& endpoint : domain.endpoints) {
      if (endpoint.participant != participant.id) continue;
      ++endpoints;
      of_nodes += !endpoint.node.empty();
    }
    text += fmt::format("; participant {}: {} endpoints, {} of a known node", participant.id,
                        endpoints, of_nodes);
  }
  return text;
}

bool is_described(const Opened& opened, const Description& description) {
  const bool is_client =
      opened.topic.starts_with(opened.writes ? "rq/" : "rr/") && description.calls_all;
  if (is_client || (!opened.writes && description.subscribes_to_all)) return true;
  for (const Described& described : description.endpoints) {
    if (opened == described) return true;
    const bool is_same_topic = opened.topic == described.topic && opened.type == described.type &&
                               opened.writes == described.writes;
    if (is_same_topic && described.or_weaker && opened.reliability <= described.reliability &&
        opened.durability <= described.durability)
      return true;
  }
  return false;
}

// The endpoints that must be there, whatever the parameters.
std::vector<Described> missing(const Description& description, const std::set<Opened>& opened) {
  std::vector<Described> all;
  for (const Described& described : description.endpoints)
    if (described.condition.empty() && !opened.contains(described)) all.push_back(described);
  return all;
}

// The endpoints of a component over several runs.
struct Use {
  Description description;
  std::set<Opened> opened;
};
using Uses = std::map<std::string, Use>;

// Runs a node until `enough(description, opened)` and compares what it opens with what it
// describes.
template <class Enough>
void run(SystemNode node, Uses& uses, const Enough& enough) {
  if (node.component == "dashboard") node.options.parameters.values["port"] = {"0", "test"};
  rt::Node watcher{"watcher"};
  const rt::DomainView view{watcher};
  Use& use = uses[node.component];
  use.description = Describer{node}.description;
  rt::RunningComponent component{node.component, node.options};
  component.start();
  std::set<Opened> opened;
  const auto is_done = [&] {
    opened = opened_by(node.options.name, view);
    return missing(use.description, opened).empty() && enough(use.description, opened);
  };
  EXPECT_TRUE(spin_until(is_done, 20.0, watcher)) << node.component << participants_in(view);
  for (const Opened& endpoint : missing(use.description, opened))
    ADD_FAILURE() << node.component << " describes, but does not open: " << endpoint;
  for (const Opened& endpoint : opened)
    EXPECT_TRUE(is_described(endpoint, use.description))
        << node.component << " opens, but does not describe: " << endpoint;
  use.opened.insert(opened.begin(), opened.end());
}

void run_system_file(const std::string& file, Uses& uses) {
  for (const auto& node : load_system(source_path("bringup/systems/" + file)).nodes)
    run(node, uses, [](const auto&, const auto&) { return true; });
}

// What is opened a while after the start: beside the node `other` of run_rare_uses(), or when other
// nodes have been discovered.
bool is_awaited(const Described& described) {
  return described.condition == "a node publishes TwistStamped" ||
         described.condition == "a node publishes it latched" ||
         described.condition == "publish_description: true";
}

// Endpoints that are opened on request only, or by the first of a process's nodes.
bool is_on_request(const Described& described) {
  return described.condition == "a web client publishes it" ||
         described.condition == "the network's guard drops a datagram";
}

// A component with parameters under which it opens what it does not open in the shipped systems.
struct Rare {
  std::string component;
  std::map<std::string, std::string> values;
};

const std::vector<Rare>& rare_uses() {
  static const std::vector<Rare> all{
      {"driver", {{"driver", "adversary"}, {"map_source", "both"}}},
      {"driver", {{"driver", "adversary"}, {"static_map", "grid"}}},
      {"obstacle_extractor", {{"map_source", "both"}, {"people", "true"}}},
      {"obstacle_extractor", {{"static_map", "grid"}}},
      {"safety_filter", {{"map_source", "both"}, {"people", "true"}, {"stamped", "true"}}},
      {"safety_filter", {{"static_map", "grid"}}},
      {"shared_dwa", {{"map_source", "both"}}},
      {"shared_dwa", {{"static_map", "grid"}}},
      {"hindsight", {{"static_map", "grid"}, {"goals", "[1.0, 1.0, 0.0]"}}},
      {"teleop", {}},
      {"haptics", {}},
      {"local_planner", {{"publish_description", "true"}, {"serve_actions", "true"}}},
      {"arbitration", {}},
      {"diff_drive_sim", {{"map", source_path("maps/forest.bt")}}}};
  return all;
}

SystemNode node_of(const Rare& rare) {
  SystemNode node{rare.component, {.name = rare.component, .use_sim_time = true}};
  for (const auto& [key, value] : rare.values)
    node.options.parameters.values[key] = {value, "test"};
  return node;
}

// Runs each of them while another node publishes every command as TwistStamped, and e_stop latched.
void run_rare_uses(Uses& uses) {
  rt::Node other{"other"};
  std::vector<rt::Publisher<geometry_msgs::msg::TwistStamped>> stamped;
  for (const auto& topic : {topics::cmd_vel, topics::cmd_vel_user, topics::cmd_vel_shared,
                            topics::cmd_vel_nav, topics::cmd_vel_arbitrated})
    stamped.push_back(
        other.create_publisher(rt::Topic<geometry_msgs::msg::TwistStamped>{topic.name, topic.qos}));
  const auto latched = other.create_publisher(topics::e_stop);
  const auto has_all = [](const Description& description, const std::set<Opened>& opened) {
    return std::all_of(description.endpoints.begin(), description.endpoints.end(),
                       [&](const Described& described) {
                         return !is_awaited(described) || opened.contains(described);
                       });
  };
  for (const Rare& rare : rare_uses()) run(node_of(rare), uses, has_all);
}

TEST(ComponentInterfaces, AreWhatTheComponentsOpen) {
  Uses uses;
  for (const char* file :
       {"forest.yaml", "teleop.yaml", "shared_dwa.yaml", "hindsight.yaml", "live_sensing.yaml"}) {
    SCOPED_TRACE(file);
    run_system_file(file, uses);
  }
  run_rare_uses(uses);
  for (const auto& component : rt::list_components())
    if (!uses.contains(component))
      run(node_of({component, {}}), uses, [](const auto&, const auto&) { return true; });
  EXPECT_GE(uses.size(), 14u);
  for (const auto& [component, use] : uses)
    for (const Described& described : use.description.endpoints)
      EXPECT_TRUE(is_on_request(described) || use.opened.contains(described))
          << component << " opens it in no run: " << Opened{described} << ", "
          << described.condition;
}

}  // namespace
}  // namespace tandem::test
