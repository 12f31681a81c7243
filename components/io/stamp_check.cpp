// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/stamp_check.hpp"

#include <cmath>
#include <utility>

#include "tandem/runtime/time.hpp"

namespace tandem {

StampCheck::StampCheck(rt::Node& node, std::string topic, const StampParams& params)
    : node_{node}, topic_{std::move(topic)}, max_age_{params.max_stamp_age}, now_{[&node] {
        return rt::to_seconds(node.stamp());
      }} {}

bool StampCheck::in_time(const builtin_interfaces::msg::Time& stamp) const {
  if (max_age_ == 0.0 || (stamp.sec() == 0 && stamp.nanosec() == 0)) return true;
  const double stamped = rt::to_seconds(stamp), age = now_() - stamped;
  const double by_computer = 1e-9 * static_cast<double>(node_.system_nanoseconds()) - stamped;
  if (std::abs(age) <= max_age_ || std::abs(by_computer) <= max_age_) return true;
  node_.log().warn_every(1.0,
                         "{}: dropped a message stamped {:.3f} s {} (max_stamp_age {} s): it "
                         "arrived late, or the publisher's clock is wrong",
                         topic_, std::abs(age), age > 0.0 ? "ago" : "ahead", max_age_);
  return false;
}

}  // namespace tandem
