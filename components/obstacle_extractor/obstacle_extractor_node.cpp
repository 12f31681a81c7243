// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"

#include <utility>

#include "tandem/config/parameter_text.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/model/reasons.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 0.1;  // [s] of odometry and /tf, which are read when a list is due

}  // namespace

rt::Interface ObstacleExtractorNode::interface() {
  return MapInput::interface() + RobotStateInput::interface() +
         rt::only_if("people: true", ObstacleTracksInput::interface()) +
         rt::Interface{.publishes = {topics::obstacles, topics::obstacle_markers}} +
         Diagnostics::interface();
}

ObstacleExtractorNode::ObstacleExtractorNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>(
          {}, [](auto& all) -> auto& { return all.extractor; },
          [this](const auto& wanted) { shapes_.set_params(extractor_for_robot(wanted)); })},
      robot_{node, params_->input},
      map_{node, params_->map, robot_.frames()},
      shapes_{extractor_for_robot(*params_), [this] { worker_.wake(); },
              [this](const auto& map, const auto& params) { return extractor_of(map, params); }},
      worker_{node.create_worker([this] { return shapes_.work(); }, [this] { publish_fitted(); })},
      obstacles_{node.create_publisher(topics::obstacles)},
      markers_{node.create_publisher(topics::obstacle_markers)},
      diagnostics_{node, {topics::obstacles.name}} {
  if (params_->people)
    on_people_ = std::make_unique<ObstacleTracksInput>(node, robot_.frames(), [this](auto all) {
      people_ = {std::move(all), node_.now()};
    });
  robot_.may_wait(kPatience);
  map_.on_live_map([this] { fit_live_map(); });
  timer_ = node.create_timer(params_->period, [this] { extract(); });
  time_jump_ = node.on_time_jump([this] { people_.reset(); });
}

// As long as its map stays, an extractor only adds tiles, which are the same for all drives in it.
std::shared_ptr<Extractor> ObstacleExtractorNode::extractor_of(
    const std::shared_ptr<const StaticMap>& map, const ExtractorParams& params) const {
  const std::string key =
      fmt::format("{} {} {}", fmt::ptr(map.get()), params.width, parameter_text(params));
  return node_.cached<Extractor>(key, [&] { return std::make_shared<Extractor>(map, params); });
}

void ObstacleExtractorNode::extract() {
  const auto robot = robot_.state();
  const auto map = map_.map(robot);
  if (!map) return report_none(map_.missing(), map_.missing_topic());
  if (!robot) return report_none(robot_.missing(), topics::odom.name);
  const auto near = shapes_.near(map, robot->X_MB.position());
  if (!near) return report_none(text_of(Reason::kNotFitted));
  if (!params_->people) return publish(*near);
  if (!people_.fresh(node_.now(), params_->people_timeout))
    return report_none(text_of(Reason::kPeopleSilent), topics::people.name);
  auto shapes = *near;
  shapes.insert(shapes.end(), people_.value.begin(), people_.value.end());
  publish(shapes);
}

// What a sensor has just seen waits for no period: it is fitted at once, and the list published.
void ObstacleExtractorNode::fit_live_map() {
  const auto robot = robot_.state();
  if (const auto map = map_.map(robot); map && robot)
    (void)shapes_.near(map, robot->X_MB.position());
}

void ObstacleExtractorNode::publish_fitted() {
  if (params_->map.map_source == "static") return;
  auto map = map_.map(robot_.state());
  if (map == listed_map_ || !shapes_.is_fitted(map)) return;
  listed_map_ = std::move(map);
  extract();
}

void ObstacleExtractorNode::report_none(const std::string& why, const char* waits_for) {
  diagnostics_.report_trouble(why, waits_for);
  reasons_.enter_missing("no obstacles: " + why);
}

void ObstacleExtractorNode::publish(const std::vector<Obstacle>& shapes) {
  reasons_.leave();
  diagnostics_.report_well("publishing nearby obstacles");
  const auto map_header = header(node_.stamp(), params_->input.frames.map);
  obstacles_.publish(to_msg(shapes, map_header));
  if (markers_.matched() == 0 || lists_++ % kMarkersEvery != 0) return;
  auto markers = to_markers(shapes, map_header);
  for (auto& region : to_markers(map_.fixtures(), map_header))
    markers.markers().push_back(std::move(region));
  markers_.publish(markers);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::ObstacleExtractorNode, "obstacle_extractor")
