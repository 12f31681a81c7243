// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/obstacle_tracks_input.hpp"

#include <utility>

#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

// With a queue, unlike topics::people: if the next list overwrote that of a second publisher, the
// two would look like one.
constexpr rt::Topic<tandem_msgs::msg::ObstacleArray> kPeople{
    topics::people.name, {.depth = 10}, topics::people.accepts};

}  // namespace

ObstacleTracksInput::ObstacleTracksInput(rt::Node& node, const FramesInput& frames, Receive receive)
    : node_{node}, frames_{frames}, receive_{std::move(receive)} {
  people_ = node.create_subscription(kPeople, [this](const auto& msg) { take(msg); });
}

rt::Interface ObstacleTracksInput::interface() { return {.subscribes = {kPeople}}; }

void ObstacleTracksInput::take(const tandem_msgs::msg::ObstacleArray& msg) {
  if (has_two_publishers())
    return node_.log().write_every(1.0, rt::LogLevel::kError, topics::people.name,
                                   "people refused: 2 nodes publish it; give the other robot its "
                                   "own namespace or ROS_DOMAIN_ID, or stop one of them");
  if (msg.header().frame_id().empty())
    return node_.log().warn_every(
        1.0, "people are given without a frame instead of in `{}`: dropped", frames_.names().map);
  const auto X_MF = frames_.in_map(msg.header(), topics::people.name);
  if (!X_MF) return;
  Obstacles people = from_msg(msg);
  if (people.refused > 0)
    return node_.log().warn_every(1.0, "{} people are {}: the list is dropped", people.refused,
                                  kNotValid);
  for (Obstacle& person : people.all) {
    person = transform(*X_MF, person);
    person.tracked = true;
  }
  receive_(std::move(people.all));
}

// Compares senders instead of matched publishers, because DDS lists a dead tracker for a while.
bool ObstacleTracksInput::has_two_publishers() {
  const double now = node_.steady_now();
  const auto sender = people_.sender();
  if (sender_ && *sender_ != sender && now - sent_ < kHoldOff) two_until_ = now + kHoldOff;
  sender_ = sender;
  sent_ = now;
  return now < two_until_;
}

}  // namespace tandem
