// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/map_input.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tandem/config/parameter_text.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/overlay.hpp"
#include "tandem/map/placed_grid.hpp"
#include "tandem/model/reasons.hpp"

namespace tandem {

// Maps of their own types, so that the many maps of live sensing do not displace static maps from
// the cache. Not in an unnamed namespace, where each module would have types of its own.
struct LiveMap {
  LiveMap(Grid grid, bool unknown_is_obstacle) : map{std::move(grid), unknown_is_obstacle} {}
  StaticMap map;
};
struct LiveGrid {
  explicit LiveGrid(Grid all) : grid{std::move(all)} {}
  Grid grid;
};

namespace {

// [m] Farther away all ground counts as unseen. The robot stops within it from any speed up to
// about 2.5 m/s; a faster one drives as if it could not see farther.
constexpr double kUnseenReach = 5.0;

constexpr double kStill = 1e-6;  // [m]; smaller motions of a frame are ignored

std::string key_of(const Grid& grid, bool unknown_is_obstacle) {
  std::string key = fmt::format("{} {} {} {} {} {} ", grid.width, grid.height, grid.resolution,
                                grid.origin.x(), grid.origin.y(), unknown_is_obstacle);
  return key.append(reinterpret_cast<const char*>(grid.cells.data()), grid.cells.size());
}

std::string key_of(const octomap_msgs::msg::Octomap& msg, const SliceParams& heights) {
  std::string key = fmt::format("{} {} {}", msg.id(), msg.binary(), msg.resolution());
  key += parameter_text(heights);
  return key.append(reinterpret_cast<const char*>(msg.data().data()), msg.data().size());
}

}  // namespace

VirtualFixtures fixtures_of(const MapInputParams& params) {
  return params.fixtures.empty() ? VirtualFixtures{} : load_virtual_fixtures(params.fixtures);
}

std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                            const MapInputParams& params,
                                            const VirtualFixtures& fixtures) {
  return std::make_shared<const StaticMap>(with_forbidden(slice(tree, params.slice), fixtures),
                                           params.unknown_is_obstacle);
}

std::shared_ptr<const StaticMap> unseen_ground_over(const Grid& known, const Grid& local,
                                                    const Eigen::Vector2d& p_MB,
                                                    const MapInputParams& params) {
  const double reach = std::min(params.local_reach, kUnseenReach);
  return std::make_shared<const StaticMap>(unknown_cells(overlay(known, local, p_MB, reach)), true);
}

MapInput::MapInput(rt::Node& node, const MapInputParams& params, const FramesInput& frames,
                   UnseenGround unseen)
    : node_{node},
      params_{params},
      heeds_unseen_{unseen},
      fixtures_{fixtures_of(params)},
      frames_{frames},
      static_{params.static_map == "grid" ? topics::map.name : topics::octomap_binary.name} {
  if (params_.map_source == "local") base_ = with_forbidden(Grid{}, fixtures_);
  if (params_.map_source != "local")
    with_static_topic([this](const auto& topic) { subscribe(topic, static_); });
  if (params_.map_source != "static") subscribe(topics::octomap_local, local_);
  // Last, so that an exception above leaves no thread running.
  worker_ = node.create_worker(
      [this] {
        take_waiting();
        return std::nullopt;
      },
      [this] { tell_of_live_map(); });
}

rt::Interface MapInput::interface_of_static() {
  return {.subscribes = {{topics::octomap_binary, "static_map: octomap"},
                         {topics::map, "static_map: grid"}}};
}

rt::Interface MapInput::interface() {
  return rt::only_if("map_source: static or both", interface_of_static()) +
         rt::Interface{.subscribes = {{topics::octomap_local, "map_source: local or both"}}};
}

template <class Use>
void MapInput::with_static_topic(const Use& use) const {
  if (params_.static_map == "grid")
    use(topics::map);
  else
    use(topics::octomap_binary);
}

template <class M>
void MapInput::subscribe(const rt::Topic<M>& topic, Inbox& inbox) {
  inbox.refused = false;
  inbox.sender.reset();
  inbox.subscription = node_.create_subscription(topic, [this, topic, &inbox](const auto& msg) {
    inbox.refused = is_foreign(topic.name, inbox);
    if (inbox.refused) return;
    inbox.sender = inbox.subscription.sender();
    hand_over(inbox, StampedMap{msg, node_.now()});
  });
}

void MapInput::hand_over(Inbox& inbox, StampedMap map) {
  const std::string frame =
      std::visit([](const auto& msg) -> std::string { return msg.header().frame_id(); }, map.value);
  const auto place = place_of(frame, inbox.refusal);
  if (place) {
    inbox.unplaced.reset();
    return hand_over(inbox, Job{std::move(map), *place});
  }
  inbox.refusal = fmt::format("{} is given in frame `{}`, not `{}`: not used: {}", inbox.topic,
                              frame, frames_.names().map, inbox.refusal);
  node_.log().missing_every(5.0, "{}", inbox.refusal);
  inbox.tried = frames_.received();
  inbox.unplaced = std::move(map);
}

void MapInput::hand_over(Inbox& inbox, Job job) {
  inbox.place = job.place;
  {
    const std::lock_guard lock{mutex_};
    inbox.waiting = std::move(job);
  }
  worker_.wake();
}

// Returns nullopt and sets `refusal` if the frame is unknown or not level.
std::optional<MapInput::Place> MapInput::place_of(const std::string& frame,
                                                  std::string& refusal) const {
  const Placing placing = frames_.in_map(frame);
  refusal = placing.refusal;
  if (!placing.X_AB) return std::nullopt;
  if (placing.X_AB->linear()(2, 2) < std::cos(kMaxTilt)) {
    refusal = "its plane is not horizontal";
    return std::nullopt;
  }
  return Place{.frame = frame,
               .X_MF = in_plane(*placing.X_AB),
               .height = placing.X_AB->translation().z(),
               .spread = placing.is_static ? 0.0 : kSpread,
               .follows = !frames_.is_map(frame)};
}

// Displacement of points near the robot when the frame moves [m].
double MapInput::shift(const Place& from, const Place& to) const {
  const Eigen::Vector2d p_MQ = p_MB_.value_or(from.X_MF.position());
  const Eigen::Vector2d p_FQ = transform(inverse(from.X_MF), p_MQ);
  return (transform(to.X_MF, p_FQ) - p_MQ).norm() +
         kNear * std::abs(wrap_angle(to.X_MF.theta - from.X_MF.theta));
}

// Queues a map whose frame has become known or has moved, and sets `trouble` if the map in force is
// misplaced. octomap_local is not queued again after a move because a new one arrives soon.
void MapInput::follow_frame(Inbox& inbox) {
  if (inbox.unplaced && inbox.tried != frames_.received())
    hand_over(inbox, *std::exchange(inbox.unplaced, std::nullopt));
  inbox.trouble.clear();
  std::unique_lock lock{mutex_};
  const auto in_force = inbox.in_force;
  lock.unlock();
  if (!in_force || !in_force->follows) return;
  const auto now_at = place_of(in_force->frame, inbox.trouble);
  if (!now_at) {
    inbox.trouble = fmt::format("{} cannot be placed: {}", inbox.topic, inbox.trouble);
    return;
  }
  if (&inbox == &static_ && inbox.place->frame == in_force->frame &&
      shift(*inbox.place, *now_at) > 0.5 * std::max(inbox.place->spread, kStill))
    hand_over(inbox, Job{.place = *now_at});
  if (shift(*in_force, *now_at) > std::max(in_force->spread, kStill))
    inbox.trouble = fmt::format("{} is being placed anew: its frame `{}` has moved", inbox.topic,
                                in_force->frame);
}

// With two publishers the map's owner is ambiguous, so keep the current map. A second publisher's
// map may arrive before DDS has counted it, so check the sender too.
bool MapInput::is_foreign(const char* topic, const Inbox& inbox) const {
  const int publishers = inbox.subscription.matched();
  if (publishers <= 1) return inbox.sender && *inbox.sender != inbox.subscription.sender();
  node_.log().write_every(1.0, rt::LogLevel::kError, topic,
                          std::string{topic} + " refused: " + std::to_string(publishers) +
                              " nodes publish it; give the other robot its own namespace or "
                              "ROS_DOMAIN_ID, or stop one of them");
  return true;
}

// Subscribing again makes the remaining publisher resend its latched map, which was rejected while
// there was a second publisher or a map_server that had crashed.
template <class M>
void MapInput::ask_again(const rt::Topic<M>& topic, Inbox& inbox) {
  if (inbox.refused && inbox.subscription.matched() <= 1) subscribe(topic, inbox);
}

std::shared_ptr<const StaticMap> MapInput::map(const std::optional<RobotState>& robot) {
  with_static_topic([this](const auto& topic) { ask_again(topic, static_); });
  ask_again(topics::octomap_local, local_);
  follow_frame(static_);
  follow_frame(local_);
  const std::lock_guard lock{mutex_};
  if (robot) p_MB_ = robot->X_MB.position();
  if (!static_.trouble.empty() || !local_.trouble.empty()) return nullptr;
  if (params_.map_source == "static") return map_.value;
  const double now = node_.now();
  // No on_time_jump() here: the worker may still hold a map that arrived before the clock jumped.
  if (map_.t > now) map_ = {map_.value};
  return map_.fresh(now, params_.local_timeout) ? map_.value : nullptr;
}

std::shared_ptr<const StaticMap> MapInput::unseen() const {
  const std::lock_guard lock{mutex_};
  return unseen_;
}

std::string MapInput::missing() const {
  for (const Inbox* inbox : {&static_, &local_})
    if (!inbox->trouble.empty()) return inbox->trouble;
  for (const Inbox* inbox : {&static_, &local_})
    if (inbox->unplaced) return inbox->refusal;
  const std::lock_guard lock{mutex_};
  return text_of(map_.value ? Reason::kLocalMapSilent : Reason::kNoMapYet);
}

const char* MapInput::missing_topic() const {
  for (const Inbox* inbox : {&static_, &local_})
    if (!inbox->trouble.empty() || inbox->unplaced) return "";
  if (params_.map_source == "static") return static_.topic;
  return params_.map_source == "both" && !static_.place ? static_.topic : local_.topic;
}

void MapInput::take_waiting() {
  std::unique_lock lock{mutex_};
  const auto fixed = std::exchange(static_.waiting, std::nullopt);
  const auto local = std::exchange(local_.waiting, std::nullopt);
  const auto p_MB = p_MB_;
  lock.unlock();
  const auto map =
      fixed ? unless_refused(static_.topic, [&] { return take_static(*fixed); }) : nullptr;
  const auto [seen, unseen] =
      local ? unless_refused("octomap_local", [&] { return take_local(*local, p_MB); }) : Live{};
  lock.lock();
  if (map) map_.value = map;
  if (map || seen) static_.in_force = base_place_;
  if (!seen) return;
  map_ = {seen, local->map->t};
  has_live_map_ = true;
  unseen_ = unseen;
  local_.in_force = local->place;
}

void MapInput::tell_of_live_map() {
  {
    const std::lock_guard lock{mutex_};
    if (!std::exchange(has_live_map_, false)) return;
  }
  if (on_live_map_) on_live_map_();
}

// Returns take(), or an empty result if it throws; logs the reason.
template <class Take>
auto MapInput::unless_refused(const char* topic, const Take& take) -> decltype(take()) {
  try {
    return take();
  } catch (const std::exception& error) {
    node_.log().write_every(1.0, rt::LogLevel::kError, topic,
                            std::string{topic} + " refused: " + error.what());
    return {};
  }
}

// Updates the base map; returns it if `map_source` is static, otherwise null.
std::shared_ptr<const StaticMap> MapInput::take_static(const Job& job) {
  if (!job.map && (!unmoved_base_ || base_place_->frame != job.place.frame)) return nullptr;
  Grid unmoved =
      job.map ? decode(job.map->value, job.place.height, false) : *std::move(unmoved_base_);
  unmoved_base_ = job.place.follows ? std::optional{unmoved} : std::nullopt;
  Grid map = placed(std::move(unmoved), job.place.X_MF, job.place.spread);
  if (params_.map_source == "both" && heeds_unseen_ == UnseenGround::kHeeded)
    known_ = with_known_ground(map);
  Grid grid = with_forbidden(std::move(map), fixtures_);
  base_place_ = job.place;
  if (job.map)
    node_.log().info("map: {} x {} cells of {:.3f} m", grid.width, grid.height, grid.resolution);
  if (params_.map_source == "static") return shared_map(std::move(grid));
  base_ = std::move(grid);
  return nullptr;
}

// Nodes with equal grids share one map, so that what is computed of a map can be shared as well.
std::shared_ptr<const StaticMap> MapInput::shared_map(Grid grid) const {
  const bool unknown_stops = params_.unknown_is_obstacle;
  const std::string key = key_of(grid, unknown_stops);
  return node_.cached<const StaticMap>(
      key, [&] { return std::make_shared<const StaticMap>(std::move(grid), unknown_stops); });
}

// shared_map() of a grid that the next scan replaces.
std::shared_ptr<const StaticMap> MapInput::shared_live_map(Grid grid) const {
  const bool unknown_stops = params_.unknown_is_obstacle;
  const std::string key = key_of(grid, unknown_stops);
  const auto live = node_.cached<const LiveMap>(
      key, [&] { return std::make_shared<const LiveMap>(std::move(grid), unknown_stops); });
  return {live, &live->map};
}

MapInput::Live MapInput::take_local(const Job& job,
                                    const std::optional<Eigen::Vector2d>& p_MB) const {
  const Grid local =
      placed(decode(job.map->value, job.place.height, true), job.place.X_MF, job.place.spread);
  if (!base_) return {};
  const Eigen::Vector2d middle =
      local.origin + 0.5 * local.resolution * Eigen::Vector2d(local.width, local.height);
  const Eigen::Vector2d p_MC = p_MB.value_or(middle);
  return {shared_live_map(overlay(*base_, local, p_MC, params_.local_reach)),
          heeds_unseen_ == UnseenGround::kHeeded ? unseen_ground_over(known_, local, p_MC, params_)
                                                 : nullptr};
}

// octomap_local may be empty when nothing is in view; an empty static map is an error.
Grid MapInput::decode(const MapMessage& msg, double height, bool may_be_empty) const {
  return std::visit([&](const auto& map) { return grid_of(map, height, may_be_empty); }, msg);
}

// Nodes that read the same map at the same heights share one result.
Grid MapInput::grid_of(const octomap_msgs::msg::Octomap& msg, double height,
                       bool may_be_empty) const {
  SliceParams in_its_frame = params_.slice;
  in_its_frame.floor -= height;
  const auto read = [&] {
    return slice_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), in_its_frame,
                         may_be_empty);
  };
  const std::string key = key_of(msg, in_its_frame);
  if (may_be_empty)
    return node_
        .cached<const LiveGrid>(key, [&] { return std::make_shared<const LiveGrid>(read()); })
        ->grid;
  return *node_.cached<const Grid>(key, [&] { return std::make_shared<const Grid>(read()); });
}

Grid MapInput::grid_of(const nav_msgs::msg::OccupancyGrid& msg, double, bool) const {
  return to_grid(from_msg(msg));
}

}  // namespace tandem
