// SPDX-License-Identifier: Apache-2.0
#include "tandem/map_server/map_server_node.hpp"

#include "tandem/io/topics.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {

rt::Interface MapServerNode::interface() {
  return {.publishes = {topics::octomap_binary, topics::map}, .other_input = "a map file"};
}

MapServerNode::MapServerNode(rt::Node& node)
    : params_{node.declare_parameters<Params>()},
      octomap_{node.create_publisher(topics::octomap_binary)},
      map_{node.create_publisher(topics::map)} {
  if (params_->map.empty())
    throw std::invalid_argument("map: give the path of an OctoMap (.bt, .ot) or of a map's YAML");
  const auto tree = load_map(params_->map);
  const auto map_header = header(node.stamp(), params_->frames.map);
  octomap_msgs::msg::Octomap msg;
  msg.header(map_header);
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(tree->getResolution());
  msg.data(encode_octomap(*tree));
  octomap_.publish(msg);
  map_.publish(to_msg(slice(*tree, params_->slice), map_header));
  node.log().info("serving {}", params_->map);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::MapServerNode, "map_server")
