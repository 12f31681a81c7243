// SPDX-License-Identifier: Apache-2.0
// Loads the component as `tandem run` does and talks to it over DDS.
#include <gtest/gtest.h>

#include <optional>

#include <tandem/runtime/component.hpp>

namespace example {
namespace {

using tandem::geometry_msgs::msg::Twist;
namespace rt = tandem::rt;

TEST(SpeedLimiterNode, LimitsWhatItReceives) {
  const auto limiter = rt::load_component("speed_limiter", {.name = "speed_limiter"});
  rt::Node node{"speed_limiter_test"};
  std::optional<Twist> received;
  const auto in = node.create_subscription(rt::Topic<Twist>{"cmd_vel_out"},
                                           [&](const Twist& message) { received = message; });
  const auto out = node.create_publisher(rt::Topic<Twist>{"cmd_vel_in"});
  Twist sent;
  sent.linear().x(2.0);
  for (int tries = 0; tries < 500 && !received; ++tries) {  // until both sides are discovered
    out.publish(sent);
    node.spin_some(0.02);
  }
  ASSERT_TRUE(received);
  EXPECT_EQ(received->linear().x(), 0.5);
}

}  // namespace
}  // namespace example
