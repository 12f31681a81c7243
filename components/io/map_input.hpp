// SPDX-License-Identifier: Apache-2.0
// Subscribes to octomap_binary or map and to octomap_local, and decodes them into a StaticMap on a
// worker thread.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
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

struct MapInputParams {
  SliceParams slice;
  bool unknown_is_obstacle = false;
  std::string fixtures;
  std::string map_source = "static";
  std::string static_map = "octomap";
  double local_timeout = 0.5;
  double local_reach = 10.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    slice.visit(field);
    field("unknown_is_obstacle", unknown_is_obstacle, "cells nobody has seen count as obstacles");
    field("fixtures", fixtures,
          "YAML file of virtual fixtures (forbidden regions, guidance lines); empty: none");
    field("map_source", map_source, OneOf{{"static", "local", "both"}},
          "static: the static map; local: octomap_local, what is seen now; both: what stands in "
          "the static map stays for ever, what octomap_local shows comes and goes");
    field("static_map", static_map, OneOf{{"octomap", "grid"}},
          "octomap: octomap_binary; grid: map, as Nav2's map_server or SLAM publishes it. Cells of "
          "50 % and more are occupied, those outside of 0 to 100 unknown");
    field("local_timeout", local_timeout, Range{0.05, 60.0},
          "[s] silence of octomap_local that counts as no map");
    field("local_reach", local_reach, Range{2.0, 100.0},
          "[m] with octomap_local the map is looked at this far round the robot");
  }
};

/// The virtual fixtures of the parameters. Throws as load_virtual_fixtures.
[[nodiscard]] VirtualFixtures fixtures_of(const MapInputParams& params);

/// The static world of a map: what stands in the slice, and what the fixtures forbid. Throws
/// std::invalid_argument or std::runtime_error, as slice and with_forbidden.
[[nodiscard]] std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                                          const MapInputParams& params,
                                                          const VirtualFixtures& fixtures);

/// The static map for a robot at p_MB that sees `local` now: over `base`, what stays.
[[nodiscard]] std::shared_ptr<const StaticMap> local_map_over(const Grid& base, const Grid& local,
                                                              const Eigen::Vector2d& p_MB,
                                                              const MapInputParams& params);

/// The same for ground that neither map knows, as obstacles; beyond its grid all is.
[[nodiscard]] std::shared_ptr<const StaticMap> unseen_ground_over(const Grid& known,
                                                                  const Grid& local,
                                                                  const Eigen::Vector2d& p_MB,
                                                                  const MapInputParams& params);

/// Whether a node also uses ground that no sensor has seen.
enum class UnseenGround { kIgnored, kHeeded };

/// Subscribes to the maps selected by `map_source` and `static_map`. Decoding a whole building
/// takes 50 to 90 ms, so a worker thread does it while the node uses the old map. Only the newest
/// message of each topic is queued. Invalid messages are logged and leave the old map in force. So
/// do maps that arrive while two nodes publish the topic, or from another publisher than the map in
/// force. When one publisher is left, its map is requested again.
///
/// A map in another frame is transformed into the map frame by `/tf` without losing obstacles, and
/// again whenever its frame has moved; a slice costs far less than decoding.
/// Obstacles of a frame that may move are grown by kSpread, and hold for so long as it has moved by
/// less: the next placing begins at half of it. Where it has moved farther, as after a jump, there
/// is no map until it is placed anew. A map whose frame is not known waits for `/tf`, and the old
/// one stays in force.
///
/// `octomap_local` is small and arrives with every scan. It is merged with the static map only
/// within `local_reach` of the robot, so that the cost of an update does not depend on the
/// building's size.
class MapInput {
 public:
  static constexpr double kSpread = 0.03;    ///< [m]
  static constexpr double kNear = 5.0;       ///< [m] from the robot, where a turn is looked at
  static constexpr double kMostTilt = 0.02;  ///< [rad] of a map's frame

  /// Throws std::runtime_error if the fixtures cannot be read.
  MapInput(rt::Node& node, const MapInputParams& params, const FramesInput& frames,
           UnseenGround unseen = UnseenGround::kIgnored);
  ~MapInput();
  MapInput(const MapInput&) = delete;
  MapInput& operator=(const MapInput&) = delete;

  [[nodiscard]] const VirtualFixtures& fixtures() const { return fixtures_; }

  /// The newest map, for a robot there; null before the first, and while octomap_local is needed
  /// and silent.
  [[nodiscard]] std::shared_ptr<const StaticMap> map(const std::optional<RobotState>& robot);

  /// Ground of the newest map that neither the static map nor any beam has covered, as obstacles;
  /// null if it is ignored, and without octomap_local.
  [[nodiscard]] std::shared_ptr<const StaticMap> unseen() const;

  /// Why map() returned null.
  [[nodiscard]] std::string missing() const;
  /// The missing topic, by its name in topics.hpp; empty if none is missing.
  [[nodiscard]] const char* missing_topic() const;

 private:
  using MapMessage = std::variant<octomap_msgs::msg::Octomap, nav_msgs::msg::OccupancyGrid>;
  using HeardMap = Stamped<MapMessage>;

  /// How the grid of a map's frame F is laid into M.
  struct Place {
    std::string frame;
    Pose2 X_MF;
    double height = 0.0;   // of F's ground in M [m]
    double spread = 0.0;   // that obstacles are grown by [m]
    bool follows = false;  // F is not the map's own frame, and may come to lie elsewhere
  };
  struct Job {
    std::optional<HeardMap> map = {};  // none: the last one again, at another place
    Place place;
  };

  struct Inbox {
    const char* topic;
    std::optional<Job> waiting = {};     // for the worker
    std::optional<Place> in_force = {};  // of the map that `map` gives
    rt::Subscription subscription = {};
    std::optional<rt::PublisherId> sender = {};  // of the map in force
    bool refused = false;                        // the last message, for another one sent it
    // The node's alone:
    std::optional<Place> place = {};        // of what was handed over last
    std::optional<HeardMap> unplaced = {};  // its frame is not known
    std::string refusal = {};               // and why
    std::uint64_t tried = 0;                // what /tf had said when that was found out
    std::string trouble = {};               // why the map in force is not where it was placed
  };

  template <class M>
  void subscribe(const rt::Topic<M>& topic, Inbox& inbox);
  void hand_over(Inbox& inbox, HeardMap map);
  void hand_over(Inbox& inbox, Job job);
  void follow_frame(Inbox& inbox);
  [[nodiscard]] std::optional<Place> place_of(const std::string& frame, std::string& refusal) const;
  [[nodiscard]] double shift(const Place& from, const Place& to) const;
  [[nodiscard]] bool is_foreign(const char* topic, const Inbox& inbox) const;
  template <class M>
  void ask_again(const rt::Topic<M>& topic, Inbox& inbox);
  void run();
  template <class Take>
  [[nodiscard]] auto unless_refused(const char* topic, const Take& take) -> decltype(take());
  [[nodiscard]] std::shared_ptr<const StaticMap> take_static(const Job& job);
  // Obstacles, and if heeded unseen ground.
  using Live = std::pair<std::shared_ptr<const StaticMap>, std::shared_ptr<const StaticMap>>;
  [[nodiscard]] Live take_local(const Job& job, const std::optional<Eigen::Vector2d>& p_MB) const;
  [[nodiscard]] Grid decode(const MapMessage& msg, double height, bool may_be_empty) const;
  [[nodiscard]] Grid grid_of(const octomap_msgs::msg::Octomap& msg, double height,
                             bool may_be_empty) const;
  [[nodiscard]] Grid grid_of(const nav_msgs::msg::OccupancyGrid& msg, double height,
                             bool may_be_empty) const;

  // Calls `use` with the topic of the static map.
  template <class Use>
  void with_static_topic(const Use& use) const;

  rt::Node& node_;
  MapInputParams params_;
  UnseenGround heeds_unseen_;
  VirtualFixtures fixtures_;
  const FramesInput& frames_;
  std::optional<Grid> base_;          // what stays, in M; the worker's
  std::optional<Grid> unmoved_base_;  // the same in its own frame, where that is another; likewise
  std::optional<Place> base_place_;   // likewise
  Grid known_;                        // the ground that it knows; likewise

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  bool stop_ = false;
  Inbox static_, local_{"octomap_local"};
  Stamped<std::shared_ptr<const StaticMap>> map_;  // when the newest octomap_local in it arrived
  std::shared_ptr<const StaticMap> unseen_;
  std::optional<Eigen::Vector2d> p_MB_;

  std::thread worker_;
};

}  // namespace tandem
