// SPDX-License-Identifier: Apache-2.0
// In: octomap_binary. Out: the static map, decoded off the node's thread.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "map/fixtures.hpp"
#include "map/slice.hpp"
#include "map/static_map.hpp"
#include "runtime/node.hpp"

namespace tandem {

struct MapInputParams {
  SliceParams slice;
  bool unknown_is_obstacle = false;
  std::string fixtures;

  template <class Visitor>
  void visit(Visitor&& field) {
    slice.visit(field);
    field("unknown_is_obstacle", unknown_is_obstacle, "cells nobody has seen count as obstacles");
    field("fixtures", fixtures,
          "YAML file of virtual fixtures (forbidden regions, guidance lines); empty: none");
  }
};

/// The virtual fixtures of the parameters. Throws std::runtime_error, as load_fixtures.
[[nodiscard]] Fixtures fixtures_of(const MapInputParams& params);

/// The static world of a map: what stands in the slice, and what the fixtures forbid. Throws
/// std::invalid_argument or std::runtime_error, as slice and with_forbidden.
[[nodiscard]] std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                                          const MapInputParams& params,
                                                          const Fixtures& fixtures);

/// Subscribes `octomap_binary` for a node. A whole building takes 50 to 90 ms to decode, so a
/// thread of its own does it; the node goes on with the old map meanwhile. Only the newest message
/// waits. Bytes that are no map are logged and leave the old map in force.
class MapInput {
 public:
  /// Throws std::runtime_error if the fixtures cannot be read.
  MapInput(rt::Node& node, const MapInputParams& params);
  ~MapInput();
  MapInput(const MapInput&) = delete;
  MapInput& operator=(const MapInput&) = delete;

  [[nodiscard]] const Fixtures& fixtures() const { return fixtures_; }

  /// The newest map; null before the first.
  [[nodiscard]] std::shared_ptr<const StaticMap> map() const;

 private:
  void run();
  [[nodiscard]] std::shared_ptr<const StaticMap> decode(const octomap_msgs::msg::Octomap& msg);

  rt::Node& node_;
  MapInputParams params_;
  Fixtures fixtures_;

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  bool stop_ = false;
  std::optional<octomap_msgs::msg::Octomap> waiting_;
  std::shared_ptr<const StaticMap> map_;

  std::thread worker_;
  rt::Subscription subscription_;
};

}  // namespace tandem
