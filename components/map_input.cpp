// SPDX-License-Identifier: Apache-2.0
#include "map_input.hpp"

#include "map/octomap_file.hpp"
#include "topics.hpp"

namespace tandem {

Fixtures fixtures_of(const MapInputParams& params) {
  return params.fixtures.empty() ? Fixtures{} : load_fixtures(params.fixtures);
}

std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                            const MapInputParams& params,
                                            const Fixtures& fixtures) {
  return std::make_shared<const StaticMap>(with_forbidden(slice(tree, params.slice), fixtures),
                                           params.unknown_is_obstacle);
}

MapInput::MapInput(rt::Node& node, const MapInputParams& params)
    : node_{node}, params_{params}, fixtures_{fixtures_of(params)} {
  worker_ = std::thread{[this] { run(); }};
  subscription_ = node.create_subscription(topics::octomap_binary,
                                           [this](const octomap_msgs::msg::Octomap& msg) {
                                             {
                                               const std::lock_guard lock{mutex_};
                                               waiting_ = msg;
                                             }
                                             arrived_.notify_one();
                                           });
}

MapInput::~MapInput() {
  subscription_ = {};
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  arrived_.notify_one();
  worker_.join();
}

std::shared_ptr<const StaticMap> MapInput::map() const {
  const std::lock_guard lock{mutex_};
  return map_;
}

void MapInput::run() {
  std::unique_lock lock{mutex_};
  while (true) {
    arrived_.wait(lock, [this] { return stop_ || waiting_; });
    if (stop_) return;
    const auto msg = std::move(*waiting_);
    waiting_.reset();
    lock.unlock();
    auto map = decode(msg);
    lock.lock();
    if (map) map_ = std::move(map);
  }
}

std::shared_ptr<const StaticMap> MapInput::decode(const octomap_msgs::msg::Octomap& msg) {
  const auto decoded = decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data());
  if (!decoded.tree) {
    node_.log().error_every(1.0, "octomap_binary refused: {}", decoded.error);
    return nullptr;
  }
  try {
    auto map = static_map(*decoded.tree, params_, fixtures_);
    const Grid& grid = map->grid();
    node_.log().info("map: {} x {} cells of {:.3f} m", grid.width, grid.height, grid.resolution);
    return map;
  } catch (const std::exception& error) {
    node_.log().error_every(1.0, "octomap_binary refused: {}", error.what());
    return nullptr;
  }
}

}  // namespace tandem
