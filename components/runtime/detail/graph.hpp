// SPDX-License-Identifier: Apache-2.0
// Publishes ros_discovery_info, which shows nodes to ROS 2 tools. Private to runtime/.
#pragma once

#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// The node that the full name of a hidden node ("/ns/_name_2") stands for; nullopt for another
/// name.
[[nodiscard]] std::optional<std::string> shown_name(const std::string& hidden);

/// Publishes which endpoints each node of this process has, after each addition or batch of
/// changes. Ends of nodes and endpoints are published with the next addition, or by publish_ends(),
/// which nodes that spin call. A process that is ending publishes none: a ROS 2 tool that reads a
/// sample after the participant's end lists its nodes for good, because rmw_dds_common takes the
/// participant up again (GraphCache::update_participant_entities).
class TANDEM_EXPORT_FOR_TESTS Graph {
 public:
  /// kOwn: the process's nodes. kHidden: the same nodes under hidden names ("_name_2"), so that
  /// tools do not list a node twice; each is published only while it has an endpoint here.
  enum class Nodes { kOwn, kHidden };

  Graph(Participant& participant, Nodes nodes);

  /// Suspends publishing. When the last batch ends, all changes are published in one sample.
  class Batch {
   public:
    explicit Batch(Graph& graph);
    ~Batch();
    Batch(const Batch&) = delete;
    Batch& operator=(const Batch&) = delete;

   private:
    Graph& graph_;
    int exceptions_ = std::uncaught_exceptions();  // when it began
  };

  /// Throws std::runtime_error if the process already has a node of that name.
  void add_node(const NodeName& node);
  void remove_node(const NodeName& node);
  void add_reader(const NodeName& node, const rtps::GUID_t& reader);
  void add_writer(const NodeName& node, const rtps::GUID_t& writer);
  void remove(const NodeName& node, const rtps::GUID_t& endpoint);
  /// Publishes the ends since the last sample, if there are any. Does not wait for other threads.
  void publish_ends();

 private:
  struct Endpoints {
    NodeName node;
    std::vector<rtps::GUID_t> readers, writers;
  };

  void announce();  // with mutex_ held
  void write();     // with mutex_ held
  Endpoints& endpoints_of(const NodeName& node);

  Participant& participant_;
  Nodes kind_;
  Writer writer_;
  std::mutex mutex_;
  std::map<std::string, Endpoints> nodes_;  // key: full name
  int batches_ = 0;
  bool changed_ = false;                 // during the current batches
  std::atomic<bool> has_ended_ = false;  // a node or endpoint, since the last sample
};

}  // namespace tandem::runtime
