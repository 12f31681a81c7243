// SPDX-License-Identifier: Apache-2.0
// Runs one component over real DDS in this process, next to a node that communicates with it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::test {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kBeat =
    0.02;  // [s] between two messages of a topic that a test publishes regularly
inline constexpr double kTravelled = 0.3;  // [m] after which a robot counts as driving

using Values = std::map<std::string, std::string>;

inline rt::NodeOptions options(const std::string& name, const Values& parameters = {}) {
  rt::NodeOptions options;
  options.name = name;
  for (const auto& [key, value] : parameters) options.parameters.values[key] = {value, "test"};
  return options;
}

class OneComponent : public ::testing::Test {
 protected:
  [[nodiscard]] static rt::RunningComponent load(const std::string& name, const Values& values) {
    return rt::load_component(name, options(name, values));
  }

  template <class Predicate>
  [[nodiscard]] bool wait_until(Predicate predicate) {
    return spin_until(predicate, kTimeout, node_);
  }

  rt::Node node_{"tester"};
};

// A timestamp of system time, `age` [s] ago.
inline builtin_interfaces::msg::Time ago(double age) {
  return rt::to_stamp(rt::system_nanoseconds() - static_cast<std::int64_t>(age * 1e9));
}

inline bool is_near(double a, double b) { return std::abs(a - b) < 1e-6; }

}  // namespace tandem::test
