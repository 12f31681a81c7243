// SPDX-License-Identifier: Apache-2.0
// In: people. Out: who walks where, for every node that must know.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "convert.hpp"
#include "runtime/node.hpp"

namespace tandem {

/// Subscribes `people` for a node. A list in another frame, or with somebody in it who is no finite
/// ellipse, is logged and dropped whole: who is left out of it might be the one in the way.
class PeopleInput {
 public:
  using Heard = std::function<void(std::vector<Obstacle>)>;

  PeopleInput(rt::Node& node, std::string map_frame, Heard heard);
  PeopleInput(const PeopleInput&) = delete;
  PeopleInput& operator=(const PeopleInput&) = delete;

 private:
  rt::Node& node_;
  std::string map_frame_;
  Heard heard_;
  rt::Subscription people_;
};

}  // namespace tandem
