// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: ros_discovery_info, by which ROS 2 tools see nodes.
#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "runtime/codec.hpp"
#include "runtime/endpoint.hpp"
#include "runtime/names.hpp"

namespace tandem::runtime {

/// Says which nodes of this process have which endpoints, anew after each change.
class Graph {
 public:
  explicit Graph(Participant& participant);

  /// Throws std::runtime_error if the process has a node of that name already.
  void add_node(const NodeName& node);
  void remove_node(const NodeName& node);
  void add_reader(const NodeName& node, const rtps::GUID_t& reader);
  void add_writer(const NodeName& node, const rtps::GUID_t& writer);
  void remove(const NodeName& node, const rtps::GUID_t& endpoint);

 private:
  struct Endpoints {
    NodeName node;
    std::vector<rtps::GUID_t> readers, writers;
  };

  void announce();  // with mutex_ held

  Participant& participant_;
  Writer writer_;
  std::mutex mutex_;
  std::map<std::string, Endpoints> nodes_;  // by full name
};

}  // namespace tandem::runtime
