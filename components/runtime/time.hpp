// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include <msgs.hpp>

namespace tandem::runtime {

/// Seconds on the machine's steady clock; only differences mean anything.
[[nodiscard]] inline double steady_seconds() {
  using std::chrono::duration;
  return duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Nanoseconds since 1970 on the system clock, as ROS 2 stamps messages.
[[nodiscard]] inline std::int64_t system_nanoseconds() {
  using std::chrono::nanoseconds;
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<nanoseconds>(since_1970).count();
}

/// Splits nanoseconds into a ROS 2 stamp.
[[nodiscard]] inline builtin_interfaces::msg::Time to_stamp(std::int64_t nanoseconds) {
  constexpr std::int64_t kBillion = 1'000'000'000;
  builtin_interfaces::msg::Time stamp;
  stamp.sec(static_cast<std::int32_t>(nanoseconds / kBillion));
  stamp.nanosec(static_cast<std::uint32_t>(nanoseconds % kBillion));
  return stamp;
}

/// A ROS 2 stamp in nanoseconds.
[[nodiscard]] inline std::int64_t to_nanoseconds(const builtin_interfaces::msg::Time& stamp) {
  return std::int64_t{stamp.sec()} * 1'000'000'000 + stamp.nanosec();
}

/// A ROS 2 stamp in seconds.
[[nodiscard]] inline double to_seconds(const builtin_interfaces::msg::Time& stamp) {
  return static_cast<double>(stamp.sec()) + 1e-9 * static_cast<double>(stamp.nanosec());
}

}  // namespace tandem::runtime
