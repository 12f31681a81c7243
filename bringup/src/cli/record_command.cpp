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
#include "bringup/bag/mcap_writer.hpp"
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

struct RecordRequest {
  std::string folder, storage = "mcap";
  std::vector<std::string> topics;
};

class Recorder {
 public:
  Recorder(rt::Node& node, const RecordRequest& request)
      : node_{node},
        storage_{request.storage == "mcap" ? BagStorage::kMcap : BagStorage::kSqlite},
        bag_{request.folder, storage_},
        wanted_{request.topics} {
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
      if (subscribe(key, qos)) add({topic.name, topic.type, qos, topic.type_hash});
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

  void add(BagTopic topic) {
    topic.qos.depth = rt::kDefault.depth;
    recorded_.at({topic.name, topic.type}).id = bag_.add_topic(topic);
    node_.log().info("recording {} [{}]", topic.name, topic.type);
    if (storage_ == BagStorage::kMcap && !is_defined(topic) && undefined_.insert(topic.type).second)
      node_.log().warn(
          "{} is recorded without its definition, which Tandem does not know: only tools that have "
          "the definition can decode it",
          topic.type);
  }

  rt::Node& node_;
  BagStorage storage_;
  BagWriter bag_;
  std::vector<std::string> wanted_;
  std::map<Key, Recorded> recorded_;
  std::set<Key> refused_;
  std::set<std::string> undefined_;  // types, each of which is warned of once
  rt::Timer looking_, committing_;
};

void record(const RecordRequest& request) {
  rt::install_signal_handlers();
  rt::Node node{"tandem_record"};
  Recorder recorder{node, request};
  node.log().info("recording into {} until Ctrl-C", request.folder);
  node.spin();
  for (const auto& name : recorder.unpublished()) node.log().warn("no program published {}", name);
  std::printf("%lld messages of %zu topics in %s\n", static_cast<long long>(recorder.messages()),
              recorder.topics(), request.folder.c_str());
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto request = std::make_shared<RecordRequest>();
  auto* command = app.add_subcommand("record", "Record topics until Ctrl-C in rosbag2's format");
  command->add_option("topics", request->topics,
                      "topics to record; default: every topic that is not hidden");
  command->add_option("-o,--output", request->folder, "output folder; default: rosbag2_<date>");
  command
      ->add_option(
          "-s,--storage", request->storage,
          "mcap, which rosbag2 writes since Iron and today's tools open, or sqlite3, which "
          "ROS 2 Humble reads, too")
      ->check(CLI::IsMember({"mcap", "sqlite3"}))
      ->capture_default_str();
  command->callback([request] {
    if (request->folder.empty()) request->folder = default_folder();
    record(*request);
  });
}

}  // namespace tandem
