// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/recorder.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "bringup/bag/mcap_writer.hpp"
#include "tandem/config/printable.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
namespace srv = rosbag2_interfaces::srv;

constexpr double kPollPeriod = 0.1;  // [s] between searches for new topics
constexpr double kCommit = 1.0;      // [s] between commits; a crash loses at most this much
constexpr int kDepth = 1000;         // messages of one topic that can wait to be written
constexpr std::string_view kScheme = "file://";

constexpr rt::ServiceName<srv::Record> kRecord{"~/record"};
constexpr rt::ServiceName<srv::Stop> kStop{"~/stop"};
constexpr rt::ServiceName<srv::Pause> kPause{"~/pause"};
constexpr rt::ServiceName<srv::Resume> kResume{"~/resume"};
constexpr rt::ServiceName<srv::IsPaused> kIsPaused{"~/is_paused"};

// ROS 2 hides topics with a name part that starts with '_'.
bool is_hidden(const std::string& topic) { return topic.find("/_") != std::string::npos; }

}  // namespace

Recorder::Recorder(rt::Node& node, const RecordRequest& request)
    : node_{node},
      storage_{request.storage == "mcap" ? BagStorage::kMcap : BagStorage::kSqlite},
      first_{fs::absolute(request.folder).lexically_normal()},
      wanted_{request.topics} {
  if (!first_.has_filename()) first_ = first_.parent_path();  // "drive/"
  for (auto& name : wanted_) name = rt::expand_name(name, {"/", node.name()});
  begin(request.folder);
  looking_ = node.create_wall_timer(kPollPeriod, [this] { look(); });
  committing_ = node.create_wall_timer(kCommit, [this] {
    if (bag_) bag_->commit();
  });
  serve();
}

std::int64_t Recorder::messages() const { return finished_ + (bag_ ? bag_->messages() : 0); }

std::vector<std::string> Recorder::unpublished() const {
  std::vector<std::string> names;
  for (const auto& name : wanted_)
    if (std::none_of(seen_.begin(), seen_.end(), [&](const Key& key) { return key.first == name; }))
      names.push_back(name);
  return names;
}

void Recorder::serve() {
  offer(kRecord, [this](const srv::Record::Request& asked, srv::Record::Response& answer) {
    try {
      if (bag_) throw std::invalid_argument("a recording is running: stop it first");
      begin(folder_of(asked.uri()));
    } catch (const std::exception& error) {
      node_.log().warn("~/record: {}", printable(error.what()));
      answer.return_code(1);
      answer.error_string(error.what());
    }
  });
  offer(kStop, [this](const auto&, auto&) { end(); });
  offer(kPause, [this](const auto&, auto&) { pause(true); });
  offer(kResume, [this](const auto&, auto&) { pause(false); });
  offer(kIsPaused, [this](const auto&, auto& answer) { answer.paused(paused_); });
}

// Under DDS Security an enclave may lack the permission; the recording goes on without.
template <class S, class Fn>
void Recorder::offer(const rt::ServiceName<S>& service, Fn fn) {
  try {
    services_.push_back(node_.create_service(service, std::move(fn)));
  } catch (const std::runtime_error& error) {
    node_.log().warn("{} is not served: {}", service.name, error.what());
  }
}

void Recorder::begin(const fs::path& folder) {
  bag_.emplace(folder.string(), storage_);
  node_.log().info("recording into {}", printable(folder.string()));
  look();
}

void Recorder::end() {
  if (!bag_) return node_.log().warn("~/stop: no recording is running");
  recorded_.clear();
  refused_.clear();
  finished_ += bag_->messages();
  bag_.reset();
  node_.log().info("the recording has ended; ~/record begins another");
}

void Recorder::pause(bool paused) {
  if (paused != paused_)
    node_.log().info("{}", paused ? "paused: messages are not recorded" : "resumed");
  paused_ = paused;
}

// A program on the bus must not choose any folder of this computer.
fs::path Recorder::folder_of(std::string uri) const {
  if (uri.starts_with(kScheme)) uri.erase(0, kScheme.size());
  const fs::path folder = (first_.parent_path() / uri).lexically_normal();
  if (uri.empty() || !folder.has_filename() || folder.parent_path() != first_.parent_path())
    throw std::invalid_argument("uri: give the name of a new folder in " +
                                first_.parent_path().string());
  return folder;
}

bool Recorder::is_wanted(const rt::TopicInfo& topic) const {
  if (topic.publishers.empty()) return false;
  if (wanted_.empty()) return !is_hidden(topic.name);
  return std::find(wanted_.begin(), wanted_.end(), topic.name) != wanted_.end();
}

void Recorder::look() {
  if (!bag_) return;
  for (const auto& topic : node_.topics()) {
    const Key key{topic.name, topic.type};
    if (!is_wanted(topic) || recorded_.contains(key) || refused_.contains(key)) continue;
    const rt::QoS qos = rt::request_for(topic.publishers, kDepth);
    if (subscribe(key, qos)) add({topic.name, topic.type, qos, topic.type_hash});
  }
}

// A topic that cannot be subscribed to, for example because its name is invalid, is skipped.
bool Recorder::subscribe(const Key& key, const rt::QoS& qos) {
  const auto& [name, type] = key;
  Recorded& recorded = recorded_[key];
  try {
    recorded.subscription =
        node_.create_generic_subscription(name, type, qos, [this, &recorded](const auto& bytes) {
          if (!paused_) bag_->write(recorded.id, rt::system_nanoseconds(), bytes);
        });
    return true;
  } catch (const std::exception& error) {
    node_.log().warn("cannot record {} [{}]: {}", name, type, error.what());
    recorded_.erase(key);
    refused_.insert(key);
    return false;
  }
}

void Recorder::add(BagTopic topic) {
  const Key key{topic.name, topic.type};
  topic.qos.depth = rt::kDefault.depth;
  recorded_.at(key).id = bag_->add_topic(topic);
  seen_.insert(key);
  node_.log().info("recording {} [{}]", topic.name, topic.type);
  if (storage_ == BagStorage::kMcap && !is_defined(topic) && undefined_.insert(topic.type).second)
    node_.log().warn(
        "{} is recorded without its definition, which Tandem does not know: only tools that have "
        "the definition can decode it",
        topic.type);
}

}  // namespace tandem
