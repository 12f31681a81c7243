// SPDX-License-Identifier: Apache-2.0
#include "people_input.hpp"

#include <utility>

#include "topics.hpp"

namespace tandem {

PeopleInput::PeopleInput(rt::Node& node, std::string map_frame, Heard heard)
    : node_{node}, map_frame_{std::move(map_frame)}, heard_{std::move(heard)} {
  people_ = node.create_subscription(topics::people, [this](const auto& msg) {
    Obstacles people = from_msg(msg);
    if (msg.header().frame_id() != map_frame_)
      node_.log().warn_every(1.0, "people are given in frame `{}`, not `{}`: dropped",
                             msg.header().frame_id(), map_frame_);
    else if (people.refused > 0)
      node_.log().warn_every(1.0, "{} people are not finite ellipses: the list is dropped",
                             people.refused);
    else
      heard_(std::move(people.all));
  });
}

}  // namespace tandem
