// SPDX-License-Identifier: Apache-2.0
#include "tandem/map_server/map_server_node.hpp"

#include "tandem/config/parameter_text.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kTick = 1e-6;  // [s] any time after 0

octomap_msgs::msg::Octomap to_msg(const octomap::OcTree& tree) {
  octomap_msgs::msg::Octomap msg;
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(tree.getResolution());
  msg.data(encode_octomap(tree));
  return msg;
}

}  // namespace

rt::Interface MapServerNode::interface() {
  return {.publishes = {topics::octomap_binary, topics::map}, .other_input = "a map file"};
}

MapServerNode::MapServerNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      octomap_{node.create_publisher(topics::octomap_binary)},
      map_{node.create_publisher(topics::map)} {
  if (params_->map.empty())
    throw std::invalid_argument("map: give the path of an OctoMap (.bt, .ot) or of a map's YAML");
  const std::string key = file_key(params_->map) + parameter_text(params_->slice);
  messages_ = node.cached<const Messages>(
      key, [this] { return std::make_shared<const Messages>(load(*params_)); });
  if (node.use_sim_time())
    clock_begins_ = node.create_timer(kTick, [this] { publish(); });
  else
    publish();
}

MapServerNode::Messages MapServerNode::load(const MapServerParams& params) {
  const auto tree = load_map(params.map);
  return {to_msg(*tree), to_msg(slice(*tree, params.slice), {})};
}

void MapServerNode::publish() {
  Messages messages = *messages_;
  messages_.reset();
  const auto map_header = header(node_.stamp(), params_->frames.map);
  messages.octomap.header(map_header);
  messages.map.header(map_header);
  messages.map.info().map_load_time(map_header.stamp());
  octomap_.publish(messages.octomap);
  map_.publish(messages.map);
  clock_begins_ = {};
  node_.log().info("serving {}", params_->map);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::MapServerNode, "map_server")
