// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/record_command.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

constexpr double kPollPeriod = 0.1;  // [s] between searches for new topics
constexpr double kCommit = 1.0;      // [s] between commits; a crash loses at most this much
constexpr int kDepth = 1000;         // messages of one topic that can wait to be written

// rosbag2's default name.
std::string default_folder() {
  char name[64];
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::strftime(name, sizeof name, "rosbag2_%Y_%m_%d-%H_%M_%S", &local);
  return name;
}

// ROS 2 hides topics with a name part that starts with '_'.
bool is_hidden(const std::string& topic) { return topic.find("/_") != std::string::npos; }

class Recorder {
 public:
  Recorder(rt::Node& node, const std::string& folder, std::vector<std::string> wanted)
      : node_{node}, bag_{folder}, wanted_{std::move(wanted)} {
    for (auto& name : wanted_) name = rt::expand_name(name, {"/", "tandem_record"});
    look();
    looking_ = node.create_wall_timer(kPollPeriod, [this] { look(); });
    committing_ = node.create_wall_timer(kCommit, [this] { bag_.commit(); });
  }

  [[nodiscard]] std::int64_t messages() const { return bag_.messages(); }
  [[nodiscard]] std::size_t topics() const { return recorded_.size(); }
  [[nodiscard]] std::vector<std::string> unpublished() const {
    std::vector<std::string> names;
    for (const auto& name : wanted_)
      if (std::none_of(recorded_.begin(), recorded_.end(),
                       [&](const auto& entry) { return entry.first.first == name; }))
        names.push_back(name);
    return names;
  }

 private:
  [[nodiscard]] bool is_wanted(const rt::TopicInfo& topic) const {
    if (topic.publishers.empty()) return false;
    if (wanted_.empty()) return !is_hidden(topic.name);
    return std::find(wanted_.begin(), wanted_.end(), topic.name) != wanted_.end();
  }

  struct Recorded {
    int id = 0;  // of the topic in the recording
    rt::Subscription subscription;
  };
  using Key = std::pair<std::string, std::string>;  // name and type

  void look() {
    for (const auto& topic : node_.topics()) {
      const Key key{topic.name, topic.type};
      if (!is_wanted(topic) || recorded_.contains(key) || refused_.contains(key)) continue;
      const rt::QoS qos = rt::request_for(topic.publishers, kDepth);
      if (subscribe(key, qos)) add(key, qos);
    }
  }

  // A topic that cannot be subscribed to, for example because its name is invalid, is skipped.
  bool subscribe(const Key& key, const rt::QoS& qos) {
    const auto& [name, type] = key;
    Recorded& recorded = recorded_[key];
    try {
      recorded.subscription =
          node_.create_generic_subscription(name, type, qos, [this, &recorded](const auto& bytes) {
            bag_.write(recorded.id, rt::system_nanoseconds(), bytes);
          });
      return true;
    } catch (const std::exception& error) {
      node_.log().warn("cannot record {} [{}]: {}", name, type, error.what());
      recorded_.erase(key);
      refused_.insert(key);
      return false;
    }
  }

  void add(const Key& key, rt::QoS offered) {
    offered.depth = rt::kDefault.depth;
    recorded_.at(key).id = bag_.add_topic({key.first, key.second, offered});
    node_.log().info("recording {} [{}]", key.first, key.second);
  }

  rt::Node& node_;
  BagWriter bag_;
  std::vector<std::string> wanted_;
  std::map<Key, Recorded> recorded_;
  std::set<Key> refused_;
  rt::Timer looking_, committing_;
};

void record(const std::string& folder, const std::vector<std::string>& topics) {
  rt::install_signal_handlers();
  rt::Node node{"tandem_record"};
  Recorder recorder{node, folder, topics};
  node.log().info("recording into {} until Ctrl-C", folder);
  node.spin();
  for (const auto& name : recorder.unpublished()) node.log().warn("no program published {}", name);
  std::printf("%lld messages of %zu topics in %s\n", static_cast<long long>(recorder.messages()),
              recorder.topics(), folder.c_str());
}

}  // namespace

void add_record_command(CLI::App& app) {
  struct Request {
    std::string folder;
    std::vector<std::string> topics;
  };
  auto request = std::make_shared<Request>();
  auto* command =
      app.add_subcommand("record", "Record topics until Ctrl-C in rosbag2's format (SQLite)");
  command->add_option("topics", request->topics,
                      "topics to record; default: every topic that is not hidden");
  command->add_option("-o,--output", request->folder, "output folder; default: rosbag2_<date>");
  command->callback([request] {
    record(request->folder.empty() ? default_folder() : request->folder, request->topics);
  });
}

}  // namespace tandem
