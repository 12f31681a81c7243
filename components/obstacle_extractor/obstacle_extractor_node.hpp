// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/io/obstacle_tracks_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/obstacle_extractor/background_extractor.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct ObstacleExtractorNodeParams {
  RobotParams robot;
  ExtractorParams extractor;
  MapInputParams map;
  RobotStateParams input;
  double period = 0.025;
  bool people = false;
  double people_timeout = 0.2;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    extractor.visit(field);
    map.visit(field);
    input.visit(field);
    field("period", period, Range{0.01, 1.0}, "[s] period of the obstacle lists");
    field("people", people,
          "true: people are listed together with static obstacles, and no list is published while "
          "`people` is silent");
    field("people_timeout", people_timeout, Range{0.02, 5.0},
          "[s] `people` counts as silent after this long without a message");
  }
};

/// The extractor's parameters with the width of the robot's outline. Throws std::invalid_argument
/// on an invalid outline, as footprint_of does.
[[nodiscard]] inline ExtractorParams extractor_for_robot(
    const ObstacleExtractorNodeParams& params) {
  ExtractorParams out = params.extractor;
  out.width = width(footprint_of(params.robot));
  out.smallest_gap = std::min(out.smallest_gap, out.width);
  return out;
}

/// octomap_binary, octomap_local, people, odom, tf → obstacles, obstacles/markers, /diagnostics.
///
/// Publishes nothing until there is a map, the robot is localized and the area is fitted, because
/// an empty list would mean "no obstacles". The diagnostics report what is missing.
class ObstacleExtractorNode {
 public:
  using Params = ObstacleExtractorNodeParams;

  static constexpr int kMarkersEvery = 8;  // lists per marker message, which is for display only

  explicit ObstacleExtractorNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  [[nodiscard]] std::shared_ptr<Extractor> extractor_of(const std::shared_ptr<const StaticMap>& map,
                                                        const ExtractorParams& params) const;
  void extract();
  void fit_live_map();
  void publish_fitted();
  void report_none(const std::string& why, const char* waits_for = "");
  void publish(const std::vector<Obstacle>& shapes);

  rt::Node& node_;
  rt::Parameters<ObstacleExtractorNodeParams> params_;
  RobotStateInput robot_;
  MapInput map_;
  BackgroundExtractor shapes_;
  std::shared_ptr<const StaticMap> listed_map_;  ///< of the last list that was published at once
  int lists_ = 0;
  rt::StateLog reasons_{node_.log(), 1.0};  ///< for publishing no list
  Stamped<std::vector<Obstacle>> people_;
  std::unique_ptr<ObstacleTracksInput> on_people_;

  rt::Worker worker_;  // destroyed before the shapes
  rt::Publisher<tandem_msgs::msg::ObstacleArray> obstacles_;
  rt::Publisher<visualization_msgs::msg::MarkerArray> markers_;
  Diagnostics diagnostics_;
  rt::Timer timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
