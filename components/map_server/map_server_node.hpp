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

/// Publishes a map file once on octomap_binary and map, latched for late subscribers: at the start,
/// under use_sim_time as soon as /clock gives the time for its stamps.
class MapServerNode {
 public:
  using Params = MapServerParams;
  /// Throws std::runtime_error if the file is not a valid map and std::invalid_argument if none is
  /// given.
  explicit MapServerNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  struct Messages {
    octomap_msgs::msg::Octomap octomap;
    nav_msgs::msg::OccupancyGrid map;
  };
  [[nodiscard]] static Messages load(const MapServerParams& params);
  void publish();

  rt::Node& node_;
  rt::Parameters<MapServerParams> params_;
  std::shared_ptr<const Messages> messages_;  // without headers; null once published
  rt::Publisher<octomap_msgs::msg::Octomap> octomap_;
  rt::Publisher<nav_msgs::msg::OccupancyGrid> map_;
  rt::Timer clock_begins_;
};

}  // namespace tandem
