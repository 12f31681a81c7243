// SPDX-License-Identifier: Apache-2.0
// Loads the component as `tandem run` does and talks to it, on a local bus and over DDS.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include <example_msgs/messages.hpp>
#include <tandem/runtime/component.hpp>
#include <tandem/runtime/local_bus.hpp>

namespace example {
namespace {

using tandem::example_msgs::msg::Limited;
using tandem::geometry_msgs::msg::Twist;
namespace rt = tandem::rt;

TEST(SpeedLimiterNode, LimitsWhatItReceivesAndReportsIt) {
  const auto bus = std::make_shared<rt::LocalBus>();
  const auto limiter = rt::load_component("speed_limiter", {.name = "speed_limiter", .bus = bus});
  rt::Node node{rt::NodeOptions{.name = "speed_limiter_test", .bus = bus}};
  std::optional<Twist> received;
  std::optional<Limited> report;
  const auto in = node.create_subscription(rt::Topic<Twist>{"cmd_vel_out"},
                                           [&](const Twist& message) { received = message; });
  const auto reports = node.create_subscription(rt::Topic<Limited>{"limited"},
                                                [&](const Limited& message) { report = message; });
  const auto out = node.create_publisher(rt::Topic<Twist>{"cmd_vel_in"});
  Twist sent;
  sent.linear().x(2.0);
  out.publish(sent);
  bus->run_for(0.1);  // simulated seconds
  ASSERT_TRUE(received && report);
  EXPECT_EQ(received->linear().x(), 0.5);
  EXPECT_EQ(report->wanted().linear().x(), 2.0);
  EXPECT_EQ(report->factor(), 0.25);
}

// ROS 2 refuses to connect topics whose types have different hashes. This one was computed by ROS 2
// (rosidl_generator_type_description) from msg/Limited.msg.
TEST(SpeedLimiterNode, AnnouncesTheTypeHashOfItsMessage) {
  const auto limiter = rt::load_component("speed_limiter", {.name = "speed_limiter"});
  rt::Node node{"speed_limiter_test"};
  std::string hash;
  for (int tries = 0; tries < 500 && hash.empty(); ++tries) {
    node.spin_some(0.02);
    for (const auto& topic : node.topics())
      if (topic.name == "/limited") hash = topic.type_hash;
  }
  EXPECT_EQ(hash, "RIHS01_449a19b9b078bfba3d31f94c4d1a520a036c017580653c1440d17a9e63fc6a0a");
}

}  // namespace
}  // namespace example
