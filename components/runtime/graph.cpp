// SPDX-License-Identifier: Apache-2.0
#include "runtime/graph.hpp"

#include <algorithm>
#include <stdexcept>

#include "runtime/log.hpp"

namespace tandem::runtime {
namespace {

using rmw_dds_common::msg::Gid;
using rmw_dds_common::msg::NodeEntitiesInfo;
using rmw_dds_common::msg::ParticipantEntitiesInfo;

Gid to_gid(const rtps::GUID_t& guid) {
  Gid gid;
  auto out = gid.data().begin();
  out = std::copy_n(guid.guidPrefix.value, rtps::GuidPrefix_t::size, out);
  std::copy_n(guid.entityId.value, rtps::EntityId_t::size, out);
  return gid;
}

std::vector<Gid> to_gids(const std::vector<rtps::GUID_t>& guids) {
  std::vector<Gid> gids(guids.size());
  std::transform(guids.begin(), guids.end(), gids.begin(), to_gid);
  return gids;
}

}  // namespace

Graph::Graph(Participant& participant)
    : participant_{participant},
      codec_{type_ref<ParticipantEntitiesInfo>()},
      writer_{participant, {"ros_discovery_info", codec_.dds_name(), kLatched}} {}

void Graph::add_node(const NodeName& node) {
  const std::lock_guard lock{mutex_};
  if (!nodes_.emplace(node.full(), Endpoints{node, {}, {}}).second)
    throw std::runtime_error("two nodes of one process are called " + node.full());
  announce();
}

void Graph::remove_node(const NodeName& node) {
  const std::lock_guard lock{mutex_};
  nodes_.erase(node.full());
  announce();
}

void Graph::add_reader(const NodeName& node, const rtps::GUID_t& reader) {
  const std::lock_guard lock{mutex_};
  nodes_.at(node.full()).readers.push_back(reader);
  announce();
}

void Graph::add_writer(const NodeName& node, const rtps::GUID_t& writer) {
  const std::lock_guard lock{mutex_};
  nodes_.at(node.full()).writers.push_back(writer);
  announce();
}

void Graph::remove(const NodeName& node, const rtps::GUID_t& endpoint) {
  const std::lock_guard lock{mutex_};
  auto& endpoints = nodes_.at(node.full());
  std::erase(endpoints.readers, endpoint);
  std::erase(endpoints.writers, endpoint);
  announce();
}

void Graph::announce() {
  ParticipantEntitiesInfo info;
  info.gid(to_gid(participant_.dds().guid()));
  for (const auto& [name, endpoints] : nodes_) {
    NodeEntitiesInfo node;
    node.node_namespace() = endpoints.node.ns;
    node.node_name() = endpoints.node.name;
    node.reader_gid_seq(to_gids(endpoints.readers));
    node.writer_gid_seq(to_gids(endpoints.writers));
    info.node_entities_info_seq().push_back(std::move(node));
  }
  Bytes bytes;
  if (!codec_.encode(&info, bytes) || !writer_.write(bytes))
    Logger{"runtime"}.warn("ros_discovery_info could not be written: ROS 2 tools miss a change");
}

}  // namespace tandem::runtime
