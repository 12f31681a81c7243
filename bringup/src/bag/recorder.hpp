// SPDX-License-Identifier: Apache-2.0
// Records topics of the ROS 2 graph, controlled by the services of rosbag2's recorder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// What is recorded, and into what.
struct RecordRequest {
  std::string folder, storage = "mcap";
  std::vector<std::string> topics;  ///< empty: every topic that is not hidden
};

/// Records from its construction until it is destroyed or stopped by ~/stop; ~/record begins
/// another recording, in a folder beside the first.
class Recorder {
 public:
  /// Throws as BagWriter does. `node` must outlive this.
  Recorder(rt::Node& node, const RecordRequest& request);

  /// Messages of all recordings.
  [[nodiscard]] std::int64_t messages() const;
  /// Topics of all recordings.
  [[nodiscard]] std::size_t topics() const { return seen_.size(); }
  /// The wanted topics that no program has published.
  [[nodiscard]] std::vector<std::string> unpublished() const;

 private:
  struct Recorded {
    int id = 0;  // of the topic in the recording
    rt::Subscription subscription;
  };
  using Key = std::pair<std::string, std::string>;  // name and type

  void serve();
  template <class S, class Fn>
  void offer(const rt::ServiceName<S>& service, Fn fn);
  void begin(const std::filesystem::path& folder);
  void end();
  void pause(bool paused);
  [[nodiscard]] std::filesystem::path folder_of(std::string uri) const;

  [[nodiscard]] bool is_wanted(const rt::TopicInfo& topic) const;
  void look();
  bool subscribe(const Key& key, const rt::QoS& qos);
  void add(BagTopic topic);

  rt::Node& node_;
  BagStorage storage_;
  std::filesystem::path first_;   // folder of the first recording
  std::optional<BagWriter> bag_;  // none: stopped
  bool paused_ = false;
  std::int64_t finished_ = 0;  // messages of the recordings that have ended
  std::vector<std::string> wanted_;
  std::map<Key, Recorded> recorded_;
  std::set<Key> refused_, seen_;
  std::set<std::string> undefined_;  // types, each of which is warned of once
  rt::Timer looking_, committing_;
  std::vector<rt::Service> services_;
};

}  // namespace tandem
