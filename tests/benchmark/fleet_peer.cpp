// SPDX-License-Identifier: Apache-2.0
// The programs of tests/benchmark/fleet other than the robots themselves:
//   fleet_peer watch NODES SECONDS   prints when that many nodes are known; ends after SECONDS
//   fleet_peer push NAMESPACE N      pushes a robot's stick N times; prints the latencies
//   fleet_peer model NAMESPACE       a robot's nodes and endpoints without their components
// Each prints one JSON object, or nothing.
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "benchmark/latency_stick.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/domain_view.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

constexpr double kLookPeriod = 0.1;  // [s]

struct Count {
  int nodes = 0, participants = 0, endpoints = 0;
  std::map<std::string, int> nodes_of;  // by namespace
};

Count count(const rt::Domain& domain) {
  Count seen;
  seen.participants = static_cast<int>(domain.participants.size());
  seen.endpoints = static_cast<int>(domain.endpoints.size());
  for (const auto& participant : domain.participants)
    for (const auto& node : participant.nodes)
      if (!participant.ours) ++seen.nodes, ++seen.nodes_of[node.substr(0, node.rfind('/'))];
  return seen;
}

// When `nodes` nodes were known, and since when the endpoints that are known at the end.
int watch(int nodes, double seconds) {
  rt::Node node{"fleet_watch"};
  const rt::DomainView view{node};
  const double begin = node.steady_now();
  double nodes_known = -1.0, endpoints_known = -1.0;  // [s] on the monotonic clock
  Count seen;
  while (node.steady_now() < begin + seconds && !rt::shutting_down()) {
    const double next = node.steady_now() + kLookPeriod;
    while (node.steady_now() < next) node.spin_some(next - node.steady_now());
    const Count now = count(view.look());
    if (nodes_known < 0.0 && now.nodes >= nodes) nodes_known = node.steady_now();
    if (now.endpoints != seen.endpoints) endpoints_known = node.steady_now();
    seen = now;
  }
  std::printf(
      "{\"nodes\": %d, \"participants\": %d, \"endpoints\": %d, \"nodes_known\": %.2f, "
      "\"endpoints_known\": %.2f, \"nodes_of\": {",
      seen.nodes, seen.participants, seen.endpoints, nodes_known, endpoints_known);
  const char* separator = "";
  for (const auto& [ns, nodes_there] : seen.nodes_of) {
    std::printf("%s\"%s\": %d", separator, ns.c_str(), nodes_there);
    separator = ", ";
  }
  std::printf("}}\n");
  return nodes_known < 0.0 ? 1 : 0;
}

int push(const std::string& ns, int pushes) {
  rt::Node node{rt::NodeOptions{.name = "fleet_stick", .ns = ns}};
  Stick stick{node};
  if (!test::spin_until([&] { return stick.connected(); }, 60.0, node)) return 1;
  std::vector<double> ms;
  for (int n = 0; n < pushes && !rt::shutting_down(); ++n) {
    stick.rest();
    const double latency = 1e3 * stick.push(n);
    if (n >= 5) ms.push_back(latency);
  }
  std::printf("[");
  for (std::size_t i = 0; i < ms.size(); ++i) std::printf("%s%.2f", i > 0 ? ", " : "", ms[i]);
  std::printf("]\n");
  return 0;
}

// As `fleet` remaps the topics with absolute names for real robots.
std::string in_namespace(std::string topic) {
  for (const char* absolute : {"/tf", "/tf_static", "/clock", "/diagnostics"})
    if (topic == absolute) topic.erase(0, 1);
  return topic;
}

// One node of the model: the endpoints that its component's interface describes.
struct ModelNode {
  ModelNode(const std::string& component, const std::string& ns)
      : node{rt::NodeOptions{.name = component, .ns = ns}} {
    const rt::Interface interface = rt::description_of(component).interface;
    for (const auto& use : interface.publishes)
      if (use.name != "*")
        publishers.push_back(
            node.create_generic_publisher(in_namespace(use.name), use.type, use.qos));
    for (const auto& use : interface.subscribes)
      if (use.name != "*")
        subscriptions.push_back(node.create_generic_subscription(in_namespace(use.name), use.type,
                                                                 use.qos, [](const auto&) {}));
  }
  rt::Node node;
  std::vector<rt::GenericPublisher> publishers;
  std::vector<rt::Subscription> subscriptions;
};

int model(const std::string& ns) {
  std::vector<std::unique_ptr<ModelNode>> nodes;
  for (const char* component :
       {"map_server", "joystick", "teleop", "obstacle_extractor", "local_planner", "arbitration",
        "safety_filter", "haptics", "dashboard", "diff_drive_sim"})
    nodes.push_back(std::make_unique<ModelNode>(component, ns));
  while (!rt::shutting_down())
    for (const auto& one : nodes) one->node.spin_some(0.05);
  return 0;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::rt::install_signal_handlers();
  const std::vector<std::string> words{argv + 1, argv + argc};
  if (words.size() == 3 && words[0] == "watch")
    return tandem::watch(std::stoi(words[1]), std::stod(words[2]));
  if (words.size() == 3 && words[0] == "push") return tandem::push(words[1], std::stoi(words[2]));
  if (words.size() == 2 && words[0] == "model") return tandem::model(words[1]);
  std::fputs("usage: fleet_peer watch NODES SECONDS | push NAMESPACE N | model NAMESPACE\n",
             stderr);
  return 2;
}
