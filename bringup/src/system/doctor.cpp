// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/doctor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "bringup/system/diagnoses.hpp"
#include "bringup/system/super_client.hpp"
#include "tandem/config/printable.hpp"
#include "tandem/io/frames_input.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

using rt::Domain;
using rt::DomainEndpoint;
using rt::GraphForm;

constexpr double kClockJump = 0.05;  // [s]

std::string description(const DomainEndpoint& endpoint) {
  return endpoint.node.empty() ? "a program that is no ROS 2 node (participant " +
                                     endpoint.participant.substr(0, 16) + "…)"
                               : endpoint.node;
}

// Pairs every publisher with every subscription on its topic.
template <class Function>
void for_each_pair(const Domain& domain, Function function) {
  for (const auto& writer : domain.endpoints)
    for (const auto& reader : domain.endpoints)
      if (writer.writes && !reader.writes && writer.topic == reader.topic) function(writer, reader);
}

// A node with two subscriptions on a topic, of different types or profiles, receives through the
// matching one.
bool receives_otherwise(const Domain& domain, const DomainEndpoint& writer,
                        const DomainEndpoint& reader) {
  return std::any_of(domain.endpoints.begin(), domain.endpoints.end(), [&](const auto& other) {
    return !other.writes && other.node == reader.node && other.topic == writer.topic &&
           other.type == writer.type && rt::qos_mismatches(writer.policies, other.policies).empty();
  });
}

// Suggests the QoS override parameter if there is one; rclcpp's nodes have it too if they allow
// overrides.
std::string remedy_at(const DomainEndpoint& endpoint, const rt::QosMismatch& mismatch) {
  const std::string value = rt::override_for(mismatch, !endpoint.writes);
  if (value.empty())
    return endpoint.writes ? "let the publisher offer " + mismatch.requested
                           : "let the subscription request " + mismatch.offered;
  return "set qos_overrides." + endpoint.topic +
         (endpoint.writes ? ".publisher." : ".subscription.") + value + " at " +
         description(endpoint);
}

void examine_qos(const Domain& domain, std::vector<Finding>& found) {
  for_each_pair(domain, [&](const auto& writer, const auto& reader) {
    if (writer.type != reader.type || receives_otherwise(domain, writer, reader)) return;
    for (const auto& mismatch : rt::qos_mismatches(writer.policies, reader.policies))
      found.push_back({writer.topic + ": " + description(writer) + " offers " + mismatch.policy +
                           " " + mismatch.offered + ", " + description(reader) + " requests " +
                           mismatch.requested + ": no messages are delivered",
                       remedy_at(reader, mismatch) + ", or " + remedy_at(writer, mismatch)});
  });
}

void examine_types(const Domain& domain, std::vector<Finding>& found) {
  std::set<std::string> reported;
  for_each_pair(domain, [&](const auto& writer, const auto& reader) {
    const bool hashes_differ = !writer.type_hash.empty() && !reader.type_hash.empty() &&
                               writer.type_hash != reader.type_hash;
    Finding finding;
    if (writer.type != reader.type && !receives_otherwise(domain, writer, reader))
      finding = {writer.topic + ": " + description(writer) + " sends " + writer.type + ", " +
                     description(reader) + " takes " + reader.type + ": no messages are delivered",
                 "remap one of them, or let both use one type"};
    else if (writer.type == reader.type && hashes_differ)
      finding = {writer.topic + ": " + description(writer) + " and " + description(reader) +
                     " use different versions of " + writer.type + " (" +
                     writer.type_hash.substr(0, 15) + "…, " + reader.type_hash.substr(0, 15) + "…)",
                 "build both with one version of the message package"};
    if (!finding.what.empty() && reported.insert(finding.what).second) found.push_back(finding);
  });
}

void examine_nodes(const Domain& domain, std::vector<Finding>& found) {
  std::map<std::string, int> nodes;
  std::set<GraphForm> forms;
  for (const auto& participant : domain.participants) {
    forms.insert(participant.form);
    for (const auto& node : participant.nodes) ++nodes[node];
  }
  for (const auto& [node, count] : nodes)
    if (count > 1)
      found.push_back({std::to_string(count) + " nodes are called " + node,
                       "rename one: --ros-args -r __node:=OTHER, or give its robot a namespace"});
  if (forms.contains(GraphForm::kHumble) && forms.contains(GraphForm::kSinceIron))
    found.push_back(
        {"ROS 2 Humble (Gids of 24 bytes) and later ones (16 bytes) share the domain; "
         "Humble's processes throw at the others' samples",
         "start Tandem with ROS_DISTRO=humble, and keep Humble and later releases of "
         "ROS 2 in different domains"});
  if (forms.contains(GraphForm::kNone))
    for (const auto& participant : domain.participants)
      if (participant.form == GraphForm::kNone)
        found.push_back({"participant " + participant.id.substr(0, 16) +
                             "… has endpoints but announces no nodes",
                         "a plain DDS program: nothing to do unless it should be a ROS 2 node"});
  if (domain.malformed > 0)
    found.push_back(
        {std::to_string(domain.malformed) + " samples of ros_discovery_info could not be read",
         "find the program that sends them; no release of ROS 2 does"});
}

// Participants of the next domain ask these ports, and one of them cannot receive multicast.
void examine_ports(const Domain& domain, std::vector<Finding>& found) {
  const auto borrowing =
      std::count_if(domain.participants.begin(), domain.participants.end(),
                    [](const auto& participant) { return participant.borrows_ports; });
  if (borrowing == 0) return;
  const std::string next = std::to_string(domain.id + 1);
  found.push_back(
      {(borrowing == 1 ? "1 participant uses" : std::to_string(borrowing) + " participants use") +
           " UDP ports of domain " + next + ": a host has more than 120 in domain " +
           std::to_string(domain.id),
       "keep domain " + next +
           " free on that host, run robots composed (one process each), or give "
           "some of them another domain"});
}

// A base executes the latest command, from any publisher.
void examine_commands(const Domain& domain, std::vector<Finding>& found) {
  std::map<std::string, std::vector<std::string>> writers;
  for (const auto& endpoint : domain.endpoints)
    if (endpoint.writes && (endpoint.topic == "/cmd_vel" || endpoint.topic.ends_with("/cmd_vel")))
      writers[endpoint.topic].push_back(description(endpoint));
  for (const auto& [topic, names] : writers) {
    if (names.size() < 2) continue;
    std::string all;
    for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
    found.push_back({topic + " has " + std::to_string(names.size()) + " publishers (" + all +
                         "): all but the safety filter's bypass it",
                     "remap all but one, to cmd_vel_nav or cmd_vel_user, or give each robot a "
                     "namespace"});
  }
}

void examine_company(const Domain& domain, std::vector<Finding>& found) {
  const bool alone = std::all_of(domain.participants.begin(), domain.participants.end(),
                                 [](const auto& participant) { return participant.ours; });
  if (alone)
    found.push_back({"no other program is on this domain",
                     "compare ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY and ROS_AUTOMATIC_DISCOVERY_RANGE "
                     "here and there; between hosts UDP multicast must pass, or ROS_STATIC_PEERS "
                     "name the other"});
}

// Detects jumps of the system clock against the steady clock, and of /clock backwards.
class ClockWatch {
 public:
  explicit ClockWatch(rt::Node& node)
      : clock_{node.create_subscription(topics::clock, [this](const auto& msg) {
          const double now = rt::to_seconds(msg.clock());
          if (last_ && now < *last_) back_ = std::max(back_, *last_ - now);
          last_ = now;
        })} {}

  void examine(std::vector<Finding>& found) const {
    const double jump = offset() - start_;
    if (std::abs(jump) > kClockJump)
      found.push_back(
          {fmt::format("the system clock jumped by {:+.3f} s", jump),
           "let chrony or ntpd slew it; the age of stamped commands is computed with it"});
    if (back_ > 0.0)
      found.push_back({fmt::format("/clock jumped back by {:.3f} s", back_),
                       "run only one simulator or player on the domain"});
  }

 private:
  static double offset() {
    return 1e-9 * static_cast<double>(rt::system_nanoseconds()) - rt::steady_seconds();
  }

  double start_ = offset();
  std::optional<double> last_;
  double back_ = 0.0;
  rt::Subscription clock_;
};

// Records the frames on /tf, and the reason in the filter's status if frames are missing.
class FrameWatch {
 public:
  explicit FrameWatch(rt::Node& node)
      : frames_{node, Frames{}, LocalizationParams{}},
        filter_{node.create_subscription(topics::filter_status, [this](const auto& msg) {
          const Reason reason = from_msg(msg.reason_code());
          if (reason == Reason::kNoCommand) return;  // it hides other reasons
          lost_ = reason == Reason::kNotLocalized ? msg.reason() : "";
        })} {}

  void print(const Domain& domain) const {
    std::printf("\nFrames\n");
    frames_.tree().for_each([&](const auto& child, const auto& parent, bool is_static,
                                const FrameSender& sender) {
      std::printf("  %-40s %-10s %s\n", printable(parent + " → " + child).c_str(),
                  is_static ? "/tf_static" : "/tf", printable(sender_name(domain, sender)).c_str());
    });
    if (frames_.received() == 0) std::printf("  nobody publishes /tf or /tf_static\n");
  }

  void examine(std::vector<Finding>& found) const {
    if (const auto two = frames_.two_parents(); !two.empty())
      found.push_back({two, "let one of the two stop publishing it (publish_tf: false)"});
    if (!lost_.empty())
      found.push_back({"the safety filter stops the robot: " + lost_ + "; the frames are " +
                           frames_.tree().listing(),
                       "start a localiser that publishes map → odom, or name the frames with "
                       "map_frame, odom_frame and base_frame; map_is_odom: true without one"});
  }

 private:
  static std::string sender_name(const Domain& domain, const FrameSender& sender) {
    const std::string id = FramesInput::id_of(sender);
    for (const auto& endpoint : domain.endpoints)
      if (endpoint.id == id) return description(endpoint);
    return id;
  }

  FramesInput frames_;
  std::string lost_;  // why the filter does not know the robot's pose; empty if it does
  rt::Subscription filter_;
};

std::string value_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

void print_environment() {
  const std::string domain = value_of("ROS_DOMAIN_ID");
  std::printf("Domain %s", domain.empty() ? "0" : domain.c_str());
  for (const char* variable :
       {"ROS_DISTRO", "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS",
        "ROS_DISCOVERY_SERVER", "FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE",
        "TANDEM_UNGUARDED_TRANSPORTS", "TANDEM_MAX_SAMPLE_SIZE"})
    if (const auto value = value_of(variable); !value.empty())
      std::printf(", %s=%s", variable, value.c_str());
  std::printf("\n");
}

const char* name(GraphForm form) {
  switch (form) {
    case GraphForm::kNone:
      return "plain DDS";
    case GraphForm::kSinceIron:
      return "ROS 2 since Iron (Gids of 16 bytes)";
    case GraphForm::kHumble:
      return "ROS 2 Humble (Gids of 24 bytes)";
  }
  return "";
}

void print_participants(const Domain& domain) {
  std::printf("\nNodes\n");
  for (const auto& participant : domain.participants)
    for (const auto& node : participant.nodes)
      if (!participant.ours)
        std::printf("  %-40s %s\n", printable(node).c_str(), name(participant.form));
}

void print_topics(const Domain& domain) {
  struct Count {
    int publishers = 0, subscriptions = 0;
    std::string hash;
  };
  std::map<std::pair<std::string, std::string>, Count> topics;
  for (const auto& endpoint : domain.endpoints) {
    if (!endpoint.topic.starts_with('/')) continue;  // services, ros_discovery_info
    auto& count = topics[{endpoint.topic, endpoint.type}];
    ++(endpoint.writes ? count.publishers : count.subscriptions);
    if (!endpoint.type_hash.empty()) count.hash = endpoint.type_hash.substr(0, 15) + "…";
  }
  std::printf("\nTopics%73s\n", "pub sub");
  for (const auto& [key, count] : topics)
    std::printf("  %-28s %-44s %3d %3d  %s\n", printable(key.first).c_str(),
                printable(key.second).c_str(), count.publishers, count.subscriptions,
                printable(count.hash).c_str());
}

int print_findings(const std::vector<Finding>& found) {
  const bool well = std::all_of(found.begin(), found.end(),
                                [](const Finding& finding) { return finding.is_note; });
  if (well)
    std::printf("\nNothing is wrong%s.\n",
                found.empty() ? "" : "; the robot is waiting for someone to steer");
  for (const auto& finding : found)
    std::printf("\n%c %s\n  → %s\n", finding.is_note ? '-' : '!', printable(finding.what).c_str(),
                printable(finding.remedy).c_str());
  return well ? 0 : 1;
}

int visit(double duration) {
  rt::install_signal_handlers();
  rt::Node node{"tandem_doctor"};
  const rt::DomainView view{node};
  const ClockWatch clock{node};
  const FrameWatch frames{node};
  Diagnoses diagnoses;
  const auto diagnostics = node.create_subscription(
      topics::diagnostics, [&diagnoses](const auto& msg) { add(diagnoses, msg); });
  for (double left = duration, end = node.steady_now() + duration; left > 0.0 && !node.stopped();
       left = end - node.steady_now())
    node.spin_some(left);
  const Domain domain = view.look();
  print_environment();
  print_participants(domain);
  print_topics(domain);
  frames.print(domain);
  auto found = examine(domain);
  clock.examine(found);
  frames.examine(found);
  for (auto& finding : examine(diagnoses, found)) found.push_back(std::move(finding));
  for (const auto& segment : stale_segments("/dev/shm", "/proc"))
    found.push_back({segment + " was left behind by a program that died",
                     "rm " + segment + " (or `fastdds shm clean`)"});
  return print_findings(found);
}

}  // namespace

std::vector<Finding> examine(const Domain& domain) {
  std::vector<Finding> found;
  examine_company(domain, found);
  examine_types(domain, found);
  examine_qos(domain, found);
  examine_nodes(domain, found);
  examine_ports(domain, found);
  examine_commands(domain, found);
  return found;
}

std::vector<std::string> stale_segments(const std::string& folder, const std::string& processes) {
  std::vector<std::string> segments;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator{folder, none}) {
    const std::string file = entry.path().filename();
    if (file.starts_with("fastrtps_") || file.starts_with("fastdds_"))
      segments.push_back(entry.path());
  }
  if (segments.empty()) return {};
  for (const auto& process : fs::directory_iterator{processes, none}) {
    if (process.path().filename().string().find_first_not_of("0123456789") != std::string::npos)
      continue;
    std::ifstream maps{process.path() / "maps"};
    if (!maps) return {};
    for (std::string line; std::getline(maps, line);)
      std::erase_if(segments, [&](const std::string& segment) { return line.ends_with(segment); });
  }
  std::sort(segments.begin(), segments.end());
  return segments;
}

void add_doctor_command(CLI::App& app, int& status) {
  auto duration = std::make_shared<double>(3.0);
  auto* command = app.add_subcommand(
      "doctor", "Show the domain's nodes and topics, and report problems; exit status 1 if any");
  command->add_option("--wait", *duration, "[s] time to observe the domain")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->callback([duration, &status] {
    become_super_client();
    status = visit(*duration);
  });
}

}  // namespace tandem
