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
  append(first.other_input, second.other_input);
  append(first.other_output, second.other_output);
  return first;
}

Interface only_if(const std::string& condition, Interface interface) {
  for (auto* topics : {&interface.subscribes, &interface.publishes})
    for (TopicUse& use : *topics)
      use.condition = condition + (use.condition.empty() ? "" : ", " + use.condition);
  return interface;
}

}  // namespace tandem::runtime
