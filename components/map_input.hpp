// SPDX-License-Identifier: Apache-2.0
// In: octomap_binary, octomap_local. Out: the world they show, decoded off the node's thread.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "map/fixtures.hpp"
#include "map/slice.hpp"
#include "map/static_map.hpp"
#include "model/heard.hpp"
#include "model/localization.hpp"
#include "runtime/node.hpp"

namespace tandem {

struct MapInputParams {
  SliceParams slice;
  bool unknown_is_obstacle = false;
  std::string fixtures;
  std::string map_source = "static";
  double local_timeout = 0.5;
  double local_reach = 10.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    slice.visit(field);
    field("unknown_is_obstacle", unknown_is_obstacle, "cells nobody has seen count as obstacles");
    field("fixtures", fixtures,
          "YAML file of virtual fixtures (forbidden regions, guidance lines); empty: none");
    field("map_source", map_source, OneOf{{"static", "local", "both"}},
          "static: octomap_binary; local: octomap_local, what is seen now; both: what stands in "
          "octomap_binary stays for ever, what octomap_local shows comes and goes");
    field("local_timeout", local_timeout, Range{0.05, 60.0},
          "[s] silence of octomap_local that counts as no map");
    field("local_reach", local_reach, Range{2.0, 100.0},
          "[m] with octomap_local the map is looked at this far round the robot");
  }
};

/// The virtual fixtures of the parameters. Throws std::runtime_error, as load_fixtures.
[[nodiscard]] Fixtures fixtures_of(const MapInputParams& params);

/// The static world of a map: what stands in the slice, and what the fixtures forbid. Throws
/// std::invalid_argument or std::runtime_error, as slice and with_forbidden.
[[nodiscard]] std::shared_ptr<const StaticMap> static_map(const octomap::OcTree& tree,
                                                          const MapInputParams& params,
                                                          const Fixtures& fixtures);

/// The static map for a robot at p_MB that sees `local` now: over `base`, what stays.
[[nodiscard]] std::shared_ptr<const StaticMap> local_map_over(const Grid& base, const Grid& local,
                                                              const Eigen::Vector2d& p_MB,
                                                              const MapInputParams& params);

/// Subscribes the maps for a node, by `map_source`. A whole building takes 50 to 90 ms to decode,
/// so a thread of its own does it; the node goes on with the old map meanwhile. Only the newest
/// message of each topic waits. Bytes that are no map are logged and leave the old map in force; so
/// does a map that comes while two nodes publish its topic, or from another one than the one in
/// force. Once one is left, its map is asked for.
///
/// `octomap_local` is small and comes with every scan. It is laid over the static map within
/// `local_reach` of the robot only, so that an update costs the same in any building.
class MapInput {
 public:
  /// Throws std::runtime_error if the fixtures cannot be read.
  MapInput(rt::Node& node, const MapInputParams& params);
  ~MapInput();
  MapInput(const MapInput&) = delete;
  MapInput& operator=(const MapInput&) = delete;

  [[nodiscard]] const Fixtures& fixtures() const { return fixtures_; }

  /// The newest map, for a robot there; null before the first, and while octomap_local is needed
  /// and silent.
  [[nodiscard]] std::shared_ptr<const StaticMap> map(const std::optional<RobotState>& robot);

  /// Why `map` gave none.
  [[nodiscard]] const char* missing() const;

 private:
  using HeardMap = Heard<octomap_msgs::msg::Octomap>;

  struct Inbox {
    std::optional<HeardMap> waiting = {};  // for the worker
    rt::Subscription subscription = {};
    std::optional<rt::PublisherId> sender = {};  // of the map in force
    bool refused = false;                        // the last message, for another one sent it
  };

  void subscribe(const rt::Topic<octomap_msgs::msg::Octomap>& topic, Inbox& inbox);
  [[nodiscard]] bool is_foreign(const char* topic, const Inbox& inbox) const;
  void ask_again(const rt::Topic<octomap_msgs::msg::Octomap>& topic, Inbox& inbox);
  void run();
  template <class Take>
  [[nodiscard]] std::shared_ptr<const StaticMap> unless_refused(const char* topic,
                                                                const Take& take);
  [[nodiscard]] std::shared_ptr<const StaticMap> take_static(const octomap_msgs::msg::Octomap& msg);
  [[nodiscard]] std::shared_ptr<const StaticMap> take_local(
      const octomap_msgs::msg::Octomap& msg, const std::optional<Eigen::Vector2d>& p_MB) const;
  [[nodiscard]] Grid decode(const octomap_msgs::msg::Octomap& msg, bool may_be_empty) const;

  rt::Node& node_;
  MapInputParams params_;
  Fixtures fixtures_;
  std::optional<Grid> base_;  // what stays; the worker's

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  bool stop_ = false;
  Inbox static_, local_;
  Heard<std::shared_ptr<const StaticMap>> map_;  // when the newest octomap_local in it arrived
  std::optional<Eigen::Vector2d> p_MB_;

  std::thread worker_;
};

}  // namespace tandem
