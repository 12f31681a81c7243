// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/interface.hpp"

namespace tandem::runtime {
namespace {

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

void append(std::string& all, const std::string& more) {
  if (!more.empty()) all += (all.empty() ? "" : ", ") + more;
}

}  // namespace

Interface operator+(Interface first, const Interface& second) {
  append(first.subscribes, second.subscribes);
  append(first.publishes, second.publishes);
  append(first.serves, second.serves);
  append(first.calls, second.calls);
  append(first.serves_actions, second.serves_actions);
  append(first.calls_actions, second.calls_actions);
  append(first.other_input, second.other_input);
  append(first.other_output, second.other_output);
  return first;
}

Interface only_if(const std::string& condition, Interface interface) {
  const auto add_to = [&](auto& uses) {
    for (auto& use : uses)
      use.condition = condition + (use.condition.empty() ? "" : ", " + use.condition);
  };
  for (auto* topics : {&interface.subscribes, &interface.publishes}) add_to(*topics);
  for (auto* services : {&interface.serves, &interface.calls}) add_to(*services);
  for (auto* actions : {&interface.serves_actions, &interface.calls_actions}) add_to(*actions);
  return interface;
}

}  // namespace tandem::runtime
