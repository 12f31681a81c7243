// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/navigation_input.hpp"

#include "tandem/io/topics.hpp"

namespace tandem {

NavigationInput::NavigationInput(rt::Node& node)
    : node_{node},
      on_status_{node.create_subscription(
          topics::arbitration_status,
          [this](const auto& msg) {
            arbitration_ = {{msg.policy(), msg.emergency_stop()}, node_.now()};
            if (on_arbitration_) on_arbitration_();
          })},
      on_filter_{node.create_subscription(topics::filter_status,
                                          [this](const auto& msg) {
                                            filter_enforces_ = {msg.enforcing(), node_.now()};
                                          })},
      time_jump_{node.on_time_jump([this] {
        arbitration_.reset();
        filter_enforces_.reset();
      })} {}

rt::Interface NavigationInput::interface() {
  return {.subscribes = {topics::arbitration_status, topics::filter_status}};
}

NavigationState NavigationInput::state() const {
  NavigationState state;
  const double now = node_.now();
  if (arbitration_.fresh(now, kSilence)) {
    state.policy = arbitration_.value.policy;
    state.emergency_stop = arbitration_.value.emergency_stop;
  }
  if (filter_enforces_.fresh(now, kSilence)) state.filter_enforces = filter_enforces_.value;
  return state;
}

}  // namespace tandem
