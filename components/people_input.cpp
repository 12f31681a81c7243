// SPDX-License-Identifier: Apache-2.0
#include "people_input.hpp"

#include <utility>

#include "topics.hpp"

namespace tandem {

PeopleInput::PeopleInput(rt::Node& node, std::string map_frame, Heard heard)
    : node_{node}, map_frame_{std::move(map_frame)}, heard_{std::move(heard)} {
  people_ = node.create_subscription(topics::people, [this](const auto& msg) {
    Obstacles people = from_msg(msg);
    if (two_speak())
      node_.log().write_every(1.0, rt::LogLevel::kError, topics::people.name,
                              "people refused: 2 nodes publish it; give another robot its own "
                              "namespace or ROS_DOMAIN_ID, or stop one");
    else if (msg.header().frame_id() != map_frame_)
      node_.log().warn_every(1.0, "people are given in frame `{}`, not `{}`: dropped",
                             msg.header().frame_id(), map_frame_);
    else if (people.refused > 0)
      node_.log().warn_every(1.0, "{} people are not finite ellipses: the list is dropped",
                             people.refused);
    else
      heard_(std::move(people.all));
  });
}

// By who spoke, not by whom DDS knows: a tracker that died is known for a while yet.
bool PeopleInput::two_speak() {
  const double now = node_.steady_now();
  const auto sender = people_.sender();
  if (sender_ && *sender_ != sender && now - sent_ < kTwoSpeak) two_until_ = now + kTwoSpeak;
  sender_ = sender;
  sent_ = now;
  return now < two_until_;
}

}  // namespace tandem
