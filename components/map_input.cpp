// SPDX-License-Identifier: Apache-2.0
#include "map_input.hpp"

#include <stdexcept>
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
  if (params_.map_source != "local") subscribe(topics::octomap_binary, static_);
  if (params_.map_source != "static") subscribe(topics::octomap_local, local_);
  worker_ = std::thread{[this] { run(); }};  // last: whoever throws before has no thread to end
}

MapInput::~MapInput() {
  static_.subscription = {};
  local_.subscription = {};
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  arrived_.notify_one();
  worker_.join();
}

void MapInput::subscribe(const rt::Topic<octomap_msgs::msg::Octomap>& topic, Inbox& inbox) {
  inbox.refused = false;
  inbox.sender.reset();
  inbox.subscription = node_.create_subscription(topic, [this, topic, &inbox](const auto& msg) {
    inbox.refused = is_foreign(topic.name, inbox);
    if (inbox.refused) return;
    inbox.sender = inbox.subscription.sender();
    {
      const std::lock_guard lock{mutex_};
      inbox.waiting = {msg, node_.now()};
    }
    arrived_.notify_one();
  });
}

// Where two publish, nobody knows whose map is this robot's: the one in force stays. A second one's
// map may come before DDS has counted it, so who sent it counts too.
bool MapInput::is_foreign(const char* topic, const Inbox& inbox) const {
  const int publishers = inbox.subscription.matched();
  if (publishers <= 1) return inbox.sender && *inbox.sender != inbox.subscription.sender();
  node_.log().write_every(
      1.0, rt::LogLevel::kError, topic,
      std::string{topic} + " refused: " + std::to_string(publishers) +
          " nodes publish it; give another robot its own namespace or ROS_DOMAIN_ID, or stop one");
  return true;
}

// Who is left sends its latched map to whoever subscribes anew: to one that was refused for another
// robot's sake, or for that of a map_server that died without a word.
void MapInput::ask_again(const rt::Topic<octomap_msgs::msg::Octomap>& topic, Inbox& inbox) {
  if (inbox.refused && inbox.subscription.matched() <= 1) subscribe(topic, inbox);
}

std::shared_ptr<const StaticMap> MapInput::map(const std::optional<RobotState>& robot) {
  ask_again(topics::octomap_binary, static_);
  ask_again(topics::octomap_local, local_);
  const std::lock_guard lock{mutex_};
  if (robot) p_MB_ = robot->X_MB.position();
  if (params_.map_source == "static") return map_.value;
  map_.forget_later_than(node_.now());
  return map_.fresh(node_.now(), params_.local_timeout) ? map_.value : nullptr;
}

const char* MapInput::missing() const {
  const std::lock_guard lock{mutex_};
  return map_.value ? "octomap_local is silent" : "no map yet";
}

void MapInput::run() {
  std::unique_lock lock{mutex_};
  while (true) {
    arrived_.wait(lock, [this] { return stop_ || static_.waiting || local_.waiting; });
    if (stop_) return;
    const auto fixed = std::exchange(static_.waiting, std::nullopt);
    const auto local = std::exchange(local_.waiting, std::nullopt);
    const auto p_MB = p_MB_;
    lock.unlock();
    const auto map =
        fixed ? unless_refused("octomap_binary", [&] { return take_static(fixed->value); })
              : nullptr;
    const auto seen =
        local ? unless_refused("octomap_local", [&] { return take_local(local->value, p_MB); })
              : nullptr;
    lock.lock();
    if (map) map_.value = map;
    if (seen) map_ = {seen, local->t};
  }
}

// What `take` makes of a message; null, and the reason logged, if it throws.
template <class Take>
std::shared_ptr<const StaticMap> MapInput::unless_refused(const char* topic, const Take& take) {
  try {
    return take();
  } catch (const std::exception& error) {
    node_.log().write_every(1.0, rt::LogLevel::kError, topic,
                            std::string{topic} + " refused: " + error.what());
    return nullptr;
  }
}

// The map of octomap_binary alone, if that is all that is asked for.
std::shared_ptr<const StaticMap> MapInput::take_static(const octomap_msgs::msg::Octomap& msg) {
  Grid grid = with_forbidden(decode(msg, false), fixtures_);
  node_.log().info("map: {} x {} cells of {:.3f} m", grid.width, grid.height, grid.resolution);
  if (params_.map_source == "static")
    return std::make_shared<const StaticMap>(std::move(grid), params_.unknown_is_obstacle);
  base_ = std::move(grid);
  return nullptr;
}

std::shared_ptr<const StaticMap> MapInput::take_local(
    const octomap_msgs::msg::Octomap& msg, const std::optional<Eigen::Vector2d>& p_MB) const {
  const Grid local = decode(msg, true);
  if (!base_) return nullptr;
  const Eigen::Vector2d middle =
      local.origin + 0.5 * local.resolution * Eigen::Vector2d(local.width, local.height);
  return local_map_over(*base_, local, p_MB.value_or(middle), params_);
}

// Where nothing is seen nothing may stand: only a map that stays must hold something.
Grid MapInput::decode(const octomap_msgs::msg::Octomap& msg, bool may_be_empty) const {
  const auto decoded =
      decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), may_be_empty);
  if (!decoded.tree) throw std::runtime_error(decoded.error);
  return slice(*decoded.tree, params_.slice);
}

}  // namespace tandem
