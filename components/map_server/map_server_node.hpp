// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tandem/io/conversions.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct MapServerParams {
  std::string map;
  SliceParams slice;
  Frames frames;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("map", map,
          "OctoMap file (.bt, .ot), map of Nav2's map_server (.yaml) or description (.yaml)");
    slice.visit(field);
    frames.visit(field);
  }
};

/// Publishes a map file once on octomap_binary and map, latched for late subscribers.
class MapServerNode {
 public:
  using Params = MapServerParams;
  /// Throws std::runtime_error if the file is not a valid map and std::invalid_argument if none is
  /// given.
  explicit MapServerNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  rt::Parameters<MapServerParams> params_;
  rt::Publisher<octomap_msgs::msg::Octomap> octomap_;
  rt::Publisher<nav_msgs::msg::OccupancyGrid> map_;
};

}  // namespace tandem
