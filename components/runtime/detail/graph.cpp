// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/graph.hpp"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "tandem/runtime/log.hpp"

namespace tandem::runtime {
namespace {

// The message types of ros_discovery_info, which differ between Humble and later releases.
struct SinceIron {
  using Gid = rmw_dds_common::msg::Gid;
  using Node = rmw_dds_common::msg::NodeEntitiesInfo;
  using Info = rmw_dds_common::msg::ParticipantEntitiesInfo;
};
struct Humble {
  using Gid = rmw_dds_common_humble::msg::Gid;
  using Node = rmw_dds_common_humble::msg::NodeEntitiesInfo;
  using Info = rmw_dds_common_humble::msg::ParticipantEntitiesInfo;
};

template <class Form>
typename Form::Gid to_gid(const rtps::GUID_t& guid) {
  typename Form::Gid gid;
  auto out = gid.data().begin();
  out = std::copy_n(guid.guidPrefix.value, rtps::GuidPrefix_t::size, out);
  std::copy_n(guid.entityId.value, rtps::EntityId_t::size, out);
  return gid;
}

template <class Form>
std::vector<typename Form::Gid> to_gids(const std::vector<rtps::GUID_t>& guids) {
  std::vector<typename Form::Gid> gids(guids.size());
  std::transform(guids.begin(), guids.end(), gids.begin(), to_gid<Form>);
  return gids;
}

template <class Form, class Nodes>
bool encode(const rtps::GUID_t& participant, const Nodes& nodes, Bytes& bytes) {
  typename Form::Info info;
  info.gid(to_gid<Form>(participant));
  for (const auto& [name, endpoints] : nodes) {
    typename Form::Node node;
    node.node_namespace() = endpoints.node.ns;
    node.node_name() = endpoints.node.name;
    node.reader_gid_seq(to_gids<Form>(endpoints.readers));
    node.writer_gid_seq(to_gids<Form>(endpoints.writers));
    info.node_entities_info_seq().push_back(std::move(node));
  }
  return Codec{type_ref<typename Form::Info>()}.encode(&info, bytes);
}

constexpr std::string_view kHiddenStart = "_", kHiddenEnd = "_2";

NodeName hidden(const NodeName& node) {
  return {node.ns, std::string{kHiddenStart} + node.name + std::string{kHiddenEnd}};
}

}  // namespace

std::optional<std::string> shown_name(const std::string& hidden) {
  const auto name = hidden.rfind('/') + 1;
  const std::string_view rest{hidden.data() + name, hidden.size() - name};
  if (rest.size() <= kHiddenStart.size() + kHiddenEnd.size() || !rest.starts_with(kHiddenStart) ||
      !rest.ends_with(kHiddenEnd))
    return std::nullopt;
  return hidden.substr(0, name) +
         std::string{rest.substr(kHiddenStart.size(),
                                 rest.size() - kHiddenStart.size() - kHiddenEnd.size())};
}

Graph::Graph(Participant& participant, Nodes nodes)
    : participant_{participant},
      kind_{nodes},
      writer_{participant,
              {"ros_discovery_info", Codec{type_ref<SinceIron::Info>()}.dds_name(), kLatched}} {}

void Graph::add_node(const NodeName& node) {
  const std::lock_guard lock{mutex_};
  if (!nodes_.emplace(node.full(), Endpoints{node, {}, {}}).second)
    throw std::runtime_error("two nodes of this process are named " + node.full());
  announce();
}

void Graph::remove_node(const NodeName& node) {
  const std::lock_guard lock{mutex_};
  nodes_.erase(node.full());
  has_ended_ = true;
}

void Graph::add_reader(const NodeName& node, const rtps::GUID_t& reader) {
  const std::lock_guard lock{mutex_};
  endpoints_of(node).readers.push_back(reader);
  announce();
}

void Graph::add_writer(const NodeName& node, const rtps::GUID_t& writer) {
  const std::lock_guard lock{mutex_};
  endpoints_of(node).writers.push_back(writer);
  announce();
}

void Graph::remove(const NodeName& node, const rtps::GUID_t& endpoint) {
  const std::lock_guard lock{mutex_};
  auto& endpoints = endpoints_of(node);
  std::erase(endpoints.readers, endpoint);
  std::erase(endpoints.writers, endpoint);
  if (kind_ == Nodes::kHidden && endpoints.readers.empty() && endpoints.writers.empty())
    nodes_.erase(node.full());
  has_ended_ = true;
}

void Graph::publish_ends() {
  if (!has_ended_) return;
  const std::unique_lock lock{mutex_, std::try_to_lock};  // else the next call does it
  if (lock && has_ended_) announce();
}

Graph::Endpoints& Graph::endpoints_of(const NodeName& node) {
  if (kind_ == Nodes::kHidden) nodes_.try_emplace(node.full(), Endpoints{hidden(node), {}, {}});
  return nodes_.at(node.full());
}

Graph::Batch::Batch(Graph& graph) : graph_{graph} {
  const std::lock_guard lock{graph_.mutex_};
  ++graph_.batches_;
}

Graph::Batch::~Batch() {
  const std::lock_guard lock{graph_.mutex_};
  if (--graph_.batches_ > 0 || !std::exchange(graph_.changed_, false)) return;
  if (std::uncaught_exceptions() > exceptions_)
    graph_.has_ended_ = true;  // what failed to start may end the process
  else
    graph_.write();
}

void Graph::announce() {
  if (batches_ > 0)
    changed_ = true;
  else
    write();
}

void Graph::write() {
  has_ended_ = false;
  const rtps::GUID_t& self = participant_.dds().guid();
  Bytes bytes;
  const bool encoded = participant_.speaks_humble() ? encode<Humble>(self, nodes_, bytes)
                                                    : encode<SinceIron>(self, nodes_, bytes);
  if (!encoded || !writer_.write(bytes))
    Logger{"runtime"}.warn(
        "ros_discovery_info could not be published: ROS 2 tools will miss a change");
}

}  // namespace tandem::runtime
