// SPDX-License-Identifier: Apache-2.0
#include "map_input.hpp"

#include <utility>

#include "map/octomap_file.hpp"
#include "map/overlay.hpp"
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

std::shared_ptr<const StaticMap> local_map_over(const Grid& base, const Grid& local,
                                                const Eigen::Vector2d& p_MB,
                                                const MapInputParams& params) {
  return std::make_shared<const StaticMap>(overlay(base, local, p_MB, params.local_reach),
                                           params.unknown_is_obstacle);
}

MapInput::MapInput(rt::Node& node, const MapInputParams& params)
    : node_{node}, params_{params}, fixtures_{fixtures_of(params)} {
  if (params_.map_source == "local") base_ = with_forbidden(Grid{}, fixtures_);
  worker_ = std::thread{[this] { run(); }};
  if (params_.map_source != "local") static_ = subscribe(topics::octomap_binary, waiting_static_);
  if (params_.map_source != "static") local_ = subscribe(topics::octomap_local, waiting_local_);
}

MapInput::~MapInput() {
  static_ = {};
  local_ = {};
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  arrived_.notify_one();
  worker_.join();
}

rt::Subscription MapInput::subscribe(const rt::Topic<octomap_msgs::msg::Octomap>& topic,
                                     std::optional<Arrived>& waiting) {
  return node_.create_subscription(topic, [&](const octomap_msgs::msg::Octomap& msg) {
    {
      const std::lock_guard lock{mutex_};
      waiting = Arrived{msg, node_.now()};
    }
    arrived_.notify_one();
  });
}

std::shared_ptr<const StaticMap> MapInput::map(const std::optional<RobotState>& robot) {
  const std::lock_guard lock{mutex_};
  if (robot) p_MB_ = robot->X_MB.position();
  const bool is_old = !local_time_ || node_.now() - *local_time_ > params_.local_timeout;
  return params_.map_source != "static" && is_old ? nullptr : map_;
}

void MapInput::run() {
  std::unique_lock lock{mutex_};
  while (true) {
    arrived_.wait(lock, [this] { return stop_ || waiting_static_ || waiting_local_; });
    if (stop_) return;
    const auto fixed = std::exchange(waiting_static_, std::nullopt);
    const auto local = std::exchange(waiting_local_, std::nullopt);
    const auto p_MB = p_MB_;
    lock.unlock();
    auto map = fixed ? take_static(fixed->msg) : nullptr;
    const auto seen = local ? take_local(local->msg, p_MB) : nullptr;
    lock.lock();
    if (seen) local_time_ = local->t;
    if (map || seen) map_ = seen ? seen : map;
  }
}

// The map of octomap_binary alone, if that is all that is asked for.
std::shared_ptr<const StaticMap> MapInput::take_static(const octomap_msgs::msg::Octomap& msg) {
  auto grid = decode(msg, true);
  if (!grid) return nullptr;
  node_.log().info("map: {} x {} cells of {:.3f} m", grid->width, grid->height, grid->resolution);
  if (params_.map_source == "static")
    return std::make_shared<const StaticMap>(*std::move(grid), params_.unknown_is_obstacle);
  base_ = std::move(grid);
  return nullptr;
}

std::shared_ptr<const StaticMap> MapInput::take_local(
    const octomap_msgs::msg::Octomap& msg, const std::optional<Eigen::Vector2d>& p_MB) const {
  const auto local = decode(msg, false);
  if (!local || !base_) return nullptr;
  const Eigen::Vector2d middle =
      local->origin + 0.5 * local->resolution * Eigen::Vector2d(local->width, local->height);
  return local_map_over(*base_, *local, p_MB.value_or(middle), params_);
}

// The slice of a message's map, with what the fixtures forbid if it is one that stays. Where
// nothing is seen nothing may stand: only a map that stays must hold something.
std::optional<Grid> MapInput::decode(const octomap_msgs::msg::Octomap& msg, bool stays) const {
  const auto decoded =
      decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), !stays);
  std::string error = decoded.error;
  if (decoded.tree) try {
      Grid grid = slice(*decoded.tree, params_.slice);
      return stays ? with_forbidden(std::move(grid), fixtures_) : grid;
    } catch (const std::exception& thrown) {
      error = thrown.what();
    }
  if (stays)
    node_.log().error_every(1.0, "octomap_binary refused: {}", error);
  else
    node_.log().error_every(1.0, "octomap_local refused: {}", error);
  return std::nullopt;
}

}  // namespace tandem
