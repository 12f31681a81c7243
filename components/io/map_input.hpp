// SPDX-License-Identifier: Apache-2.0
// Subscribes to octomap_binary or map and to octomap_local, and decodes them into a StaticMap
// beside the node's callbacks.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include "tandem/io/frames_input.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/map/virtual_fixtures.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Which map a node uses, and how it reads it.
struct MapInputParams {
  SliceParams slice;  ///< the heights that count
  bool unknown_is_obstacle = false;
  std::string fixtures;
  std::string map_source = "static";
  std::string static_map = "octomap";
  double local_timeout = 0.5;
  double local_reach = 10.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    slice.visit(field);
    field("unknown_is_obstacle", unknown_is_obstacle, "true: unknown cells count as obstacles");
    field("fixtures", fixtures,
          "YAML file of virtual fixtures (forbidden regions, guidance lines); empty: none");
    field("map_source", map_source, OneOf{{"static", "local", "both"}},
          "static: the static map; local: octomap_local, what the sensors see now; both: obstacles "
          "of the static map are permanent, those of octomap_local come and go");
    field("static_map", static_map, OneOf{{"octomap", "grid"}},
          "octomap: octomap_binary; grid: map, as Nav2's map_server or SLAM publishes it. Cells of "
          "50 % or more are occupied, those outside 0 to 100 are unknown");
    field("local_timeout", local_timeout, Range{0.05, 60.0},
          "[s] after this long without octomap_local there is no map");
    field("local_reach", local_reach, Range{2.0, 100.0},
          "[m] with octomap_local, the distance around the robot in which the map is used");
  }
};

/// Loads the virtual fixtures of the parameters. Throws std::runtime_error, as
/// load_virtual_fixtures.
[[nodiscard]] VirtualFixtures fixtures_of(const MapInputParams& params);

/// The static map from an octree: obstacles in the slice and regions forbidden by the fixtures.
/// Throws std::invalid_argument or std::runtime_error, as slice and with_forbidden.
[[nodiscard]] std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                                          const MapInputParams& params,
                                                          const VirtualFixtures& fixtures);

/// Ground unknown to both maps, as obstacles, within 5 m of the robot or `local_reach`; everything
/// farther away counts as unknown.
[[nodiscard]] std::shared_ptr<const StaticMap> unseen_ground_over(const Grid& known,
                                                                  const Grid& local,
                                                                  const Eigen::Vector2d& p_MB,
                                                                  const MapInputParams& params);

/// Whether a node also uses ground that no sensor has seen.
enum class UnseenGround { kIgnored, kHeeded };

/// Subscribes to the maps selected by `map_source` and `static_map`. Decoding a whole building
/// takes 50 to 90 ms, so a worker does it while the node uses the old map. Only the newest
/// message of each topic is queued. Invalid maps are logged and leave the old map in force. So do
/// maps received while two nodes publish the topic, or from a publisher other than that of the map
/// in force. When one publisher is left, its map is requested again.
///
/// A map in another frame is transformed into the map frame by `/tf` without losing obstacles, and
/// again whenever its frame has moved; a slice costs far less than decoding. Obstacles in a frame
/// that may move are grown by kSpread, which keeps the map valid while the frame moves by less. The
/// map is transformed again once it has moved by half of that. If it has moved by more, as after a
/// jump, there is no map until that is done. A map in an unknown frame waits for `/tf` while the
/// old one stays in force.
///
/// `octomap_local` is small and arrives with every scan. It is merged with the static map only
/// within `local_reach` of the robot, so that the cost of an update does not depend on the
/// building's size.
class MapInput {
 public:
  static constexpr double kSpread = 0.03;  ///< growth of obstacles in a frame that may move [m]
  static constexpr double kNear = 5.0;  ///< distance from the robot at which turns are measured [m]
  static constexpr double kMaxTilt = 0.02;  ///< maximum tilt of a map's frame [rad]

  /// Throws std::runtime_error if the fixtures cannot be read.
  MapInput(rt::Node& node, const MapInputParams& params, const FramesInput& frames,
           UnseenGround unseen = UnseenGround::kIgnored);
  /// The topics that it opens.
  [[nodiscard]] static rt::Interface interface();
  /// The same for a node that accepts `map_source: static` only.
  [[nodiscard]] static rt::Interface interface_of_static();
  MapInput(const MapInput&) = delete;
  MapInput& operator=(const MapInput&) = delete;

  /// The virtual fixtures of the parameters, in M.
  [[nodiscard]] const VirtualFixtures& fixtures() const { return fixtures_; }

  /// The newest map; null before the first one, while octomap_local is required but silent, and
  /// while the map's frame cannot be followed. `robot` sets the center of later merges.
  [[nodiscard]] std::shared_ptr<const StaticMap> map(const std::optional<RobotState>& robot);

  /// Calls `fn` on the node's thread as soon as a map that octomap_local brought is in force. Set
  /// it before the node spins.
  void on_live_map(std::function<void()> fn) { on_live_map_ = std::move(fn); }

  /// Ground in the newest map covered by neither the static map nor any beam, as obstacles; null if
  /// it is ignored or there is no octomap_local.
  [[nodiscard]] std::shared_ptr<const StaticMap> unseen() const;

  /// Why map() returned null.
  [[nodiscard]] std::string missing() const;
  /// The missing topic, by its name in topics.hpp; empty if none is missing.
  [[nodiscard]] const char* missing_topic() const;

 private:
  using MapMessage = std::variant<octomap_msgs::msg::Octomap, nav_msgs::msg::OccupancyGrid>;
  using StampedMap = Stamped<MapMessage>;

  /// Placement of a map's frame F in the map frame M.
  struct Place {
    std::string frame;
    Pose2 X_MF;
    double height = 0.0;   // of F's origin above M's [m]
    double spread = 0.0;   // growth of obstacles [m]
    bool follows = false;  // F is not the map frame, so it may move
  };
  struct Job {
    std::optional<StampedMap> map = {};  // nullopt: reuse the last map at another place
    Place place;
  };

  struct Inbox {
    const char* topic;
    std::optional<Job> waiting = {};     // job for the worker
    std::optional<Place> in_force = {};  // place of the map that map() returns
    rt::Subscription subscription = {};
    std::optional<rt::PublisherId> sender = {};  // of the map in force
    bool refused = false;                        // last message came from another publisher
    // Used by the node's thread only:
    std::optional<Place> place = {};          // place of the last job
    std::optional<StampedMap> unplaced = {};  // map in an unknown frame
    std::string refusal = {};                 // why the frame is unknown
    std::uint64_t tried = 0;                  // FramesInput::received() at that time
    std::string trouble = {};                 // why the map in force is misplaced
  };

  template <class M>
  void subscribe(const rt::Topic<M>& topic, Inbox& inbox);
  void hand_over(Inbox& inbox, StampedMap map);
  void hand_over(Inbox& inbox, Job job);
  void follow_frame(Inbox& inbox);
  [[nodiscard]] std::optional<Place> place_of(const std::string& frame, std::string& refusal) const;
  [[nodiscard]] double shift(const Place& from, const Place& to) const;
  [[nodiscard]] bool is_foreign(const char* topic, const Inbox& inbox) const;
  template <class M>
  void ask_again(const rt::Topic<M>& topic, Inbox& inbox);
  void take_waiting();
  void tell_of_live_map();
  template <class Take>
  [[nodiscard]] auto unless_refused(const char* topic, const Take& take) -> decltype(take());
  [[nodiscard]] std::shared_ptr<const StaticMap> take_static(const Job& job);
  [[nodiscard]] std::shared_ptr<const StaticMap> shared_map(Grid grid) const;
  [[nodiscard]] std::shared_ptr<const StaticMap> shared_live_map(Grid grid) const;
  // The merged map and, if heeded, unseen ground.
  using Live = std::pair<std::shared_ptr<const StaticMap>, std::shared_ptr<const StaticMap>>;
  [[nodiscard]] Live take_local(const Job& job, const std::optional<Eigen::Vector2d>& p_MB) const;
  [[nodiscard]] Grid decode(const MapMessage& msg, double height, bool may_be_empty) const;
  [[nodiscard]] Grid grid_of(const octomap_msgs::msg::Octomap& msg, double height,
                             bool may_be_empty) const;
  [[nodiscard]] Grid grid_of(const nav_msgs::msg::OccupancyGrid& msg, double height,
                             bool may_be_empty) const;

  // Calls `use` with the topic of the static map, whose type depends on `static_map`.
  template <class Use>
  void with_static_topic(const Use& use) const;

  rt::Node& node_;
  MapInputParams params_;
  UnseenGround heeds_unseen_;
  VirtualFixtures fixtures_;
  const FramesInput& frames_;

  // Used by the worker only:
  std::optional<Grid> base_;          // permanent map in M
  std::optional<Grid> unmoved_base_;  // the same in its own frame F, if F is not M
  std::optional<Place> base_place_;
  Grid known_;  // ground known to base_

  mutable std::mutex mutex_;
  Inbox static_, local_{"octomap_local"};
  Stamped<std::shared_ptr<const StaticMap>> map_;  // stamped with octomap_local's arrival
  std::shared_ptr<const StaticMap> unseen_;
  std::optional<Eigen::Vector2d> p_MB_;
  bool has_live_map_ = false;  // on_live_map_ has not been called for it yet

  std::function<void()> on_live_map_;
  rt::Worker worker_;  // last, because its work uses what is above
};

}  // namespace tandem
