// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/robot_description.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using test::kTimeout;
using test::spin_until;

class Description : public testing::Test {
 protected:
  [[nodiscard]] bool wait_until(const std::function<bool()>& done) {
    return spin_until(done, kTimeout, robot_, other_);
  }
  // What a viewer that starts now receives.
  [[nodiscard]] std::string received() {
    std::string urdf;
    const auto viewer = other_.create_subscription(topics::robot_description,
                                                   [&](const auto& msg) { urdf = msg.data(); });
    EXPECT_TRUE(wait_until([&] { return !urdf.empty(); }));
    return urdf;
  }

  rt::Node robot_{"robot"}, other_{"other"};
};

TEST_F(Description, IsLatched) {
  const RobotDescription description{robot_, "<robot/>"};
  EXPECT_EQ(received(), "<robot/>");
  EXPECT_EQ(received(), "<robot/>");
}

TEST_F(Description, IsLeftToAnotherNodeAsLongAsThatPublishesOne) {
  auto another = std::optional{other_.create_publisher(topics::robot_description)};
  std_msgs::msg::String urdf;
  urdf.data("<robot name=\"theirs\"/>");
  another->publish(urdf);
  const RobotDescription description{robot_, "<robot/>"};
  const double end = robot_.steady_now() + 1.5;  // it looks for others for a second
  ASSERT_TRUE(wait_until([&] { return robot_.steady_now() > end; }));
  EXPECT_EQ(other_.count_publishers("robot_description"), 1U);
  EXPECT_EQ(received(), urdf.data());
  another.reset();
  EXPECT_EQ(received(), "<robot/>");
  another = other_.create_publisher(topics::robot_description);
  EXPECT_TRUE(wait_until([&] { return other_.count_publishers("robot_description") == 1; }));
}

}  // namespace
}  // namespace tandem
