// SPDX-License-Identifier: Apache-2.0
// Tests which parameters `ros2 param set` may change on running components.
#include <optional>
#include <set>

#include "system/one_component.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/parameter_table.hpp"

namespace tandem::test {
namespace {

namespace srv = rcl_interfaces::srv;
namespace types = rcl_interfaces::msg::ParameterType_Constants;
using Names = std::set<std::string>;

class LiveParameters : public OneComponent {
 protected:
  template <class S>
  typename S::Response ask(const std::string& service, const typename S::Request& request) {
    const auto client = node_.create_client(rt::ServiceName<S>{service.c_str()});
    std::optional<typename S::Response> answer;
    client.call(
        request, [&](const auto& response) { answer = response; }, kTimeout);
    EXPECT_TRUE(wait_until([&] { return answer.has_value(); })) << service;
    return answer.value_or(typename S::Response{});
  }

  // Without those of every node.
  Names live(const std::string& node) {
    Names names = all_live(node);
    rt::every_node::Params common;
    for (const auto& name : rt::names_of(common)) names.erase(name);
    return names;
  }
  Names all_live(const std::string& node) {
    const auto list = ask<srv::ListParameters>(node + "/list_parameters", {}).result().names();
    EXPECT_GT(list.size(), 5U);
    srv::DescribeParameters::Request request;
    request.names(list);
    const auto answer = ask<srv::DescribeParameters>(node + "/describe_parameters", request);
    EXPECT_EQ(answer.descriptors().size(), list.size());
    Names names;
    for (const auto& descriptor : answer.descriptors()) {
      EXPECT_NE(descriptor.description(), "") << descriptor.name();
      if (!descriptor.read_only()) names.insert(descriptor.name());
    }
    return names;
  }

  // The error message; "" if the parameter was set.
  std::string set(const std::string& node, const std::string& name, double value) {
    rcl_interfaces::msg::ParameterValue wanted;
    wanted.type(types::PARAMETER_DOUBLE);
    wanted.double_value(value);
    return set(node, name, wanted);
  }
  std::string set(const std::string& node, const std::string& name, const std::string& value) {
    rcl_interfaces::msg::ParameterValue wanted;
    wanted.type(types::PARAMETER_STRING);
    wanted.string_value(value);
    return set(node, name, wanted);
  }
  std::string set(const std::string& node, const std::string& name,
                  const rcl_interfaces::msg::ParameterValue& value) {
    srv::SetParameters::Request request;
    auto& parameter = request.parameters().emplace_back();
    parameter.name(name);
    parameter.value(value);
    const auto results = ask<srv::SetParameters>(node + "/set_parameters", request).results();
    return results.size() == 1 ? results[0].reason() : "no result";
  }
};

// A stray `ros2 param set` must not disable a person's protection.
TEST_F(LiveParameters, DoNotIncludeTheSafetyFilters) {
  const auto filter = load("safety_filter", {});
  EXPECT_EQ(all_live("/safety_filter"), Names{});
  EXPECT_NE(set("/safety_filter", "enforce", 0.0).find("read-only"), std::string::npos);
}

TEST_F(LiveParameters, OfArbitrationAreHowItBlends) {
  const auto arbitration = load("arbitration", {});
  EXPECT_EQ(live("/arbitration"),
            (Names{"blend_clearance", "blend_disagreement", "blend_min", "blend_rate"}));
  EXPECT_EQ(all_live("/arbitration").size(), live("/arbitration").size() + 5);
  EXPECT_EQ(set("/arbitration", "blend_min", 0.5), "");
  EXPECT_NE(set("/arbitration", "user_timeout", 5.0).find("read-only"), std::string::npos);
}

TEST_F(LiveParameters, OfThePlannerAreCheckedAsAWhole) {
  const auto planner = load("local_planner", {});
  const Names names = live("/local_planner");
  EXPECT_TRUE(names.contains("weight_v"));
  EXPECT_TRUE(names.contains("control_period"));
  EXPECT_TRUE(names.contains("method"));
  EXPECT_FALSE(names.contains("user_timeout"));
  EXPECT_EQ(set("/local_planner", "weight_v", 0.7), "");
  EXPECT_EQ(set("/local_planner", "control_period", 0.1), "");
  EXPECT_NE(set("/local_planner", "dt", 0.05).find("control_period"), std::string::npos);
  EXPECT_EQ(set("/local_planner", "weight_v", 0.8), "");
}

TEST_F(LiveParameters, OfThePlannerAreItsMethodToo) {
  const auto planner = load("local_planner", {{"method", "leader"}});
  std::string method;
  const auto status = node_.create_subscription(topics::planner_status,
                                                [&](const auto& msg) { method = msg.method(); });
  ASSERT_TRUE(wait_until([&] { return method == "leader"; }));
  EXPECT_EQ(set("/local_planner", "method", std::string{"path"}), "");
  EXPECT_TRUE(wait_until([&] { return method == "path"; }));
  EXPECT_NE(set("/local_planner", "method", std::string{"dwa"}).find("not one of"),
            std::string::npos);
}

TEST_F(LiveParameters, OfTheExtractorAreItsFit) {
  const auto extractor = load("obstacle_extractor", {});
  EXPECT_EQ(live("/obstacle_extractor"), (Names{"range", "max_excess", "smallest_gap",
                                                "space_per_shape", "tile", "shapes_per_tile"}));
  EXPECT_EQ(set("/obstacle_extractor", "range", 5.0), "");
}

TEST_F(LiveParameters, OfTeleopChangeTheNextCommand) {
  const auto teleop = load("teleop", {{"map_is_odom", "true"}});
  double v = 0.0;
  const auto user = node_.create_subscription(topics::cmd_vel_user,
                                              [&](const auto& msg) { v = msg.linear().x(); });
  const auto joy = node_.create_publisher(topics::joy);
  long commands = 0;
  const auto counted =
      node_.create_subscription(topics::cmd_vel_user, [&](const auto&) { ++commands; });
  sensor_msgs::msg::Joy stick;
  stick.axes({0.0f, 0.0f});
  stick.buttons({1, 0});
  const auto beat = node_.create_wall_timer(0.02, [&] { joy.publish(stick); });
  ASSERT_TRUE(wait_until([&] { return commands > 0; }));  // it was seen at rest
  stick.axes({0.0f, 1.0f});
  ASSERT_TRUE(wait_until([&] { return is_near(v, 0.8); }));
  EXPECT_EQ(set("/teleop", "scale_linear", 0.3), "");
  EXPECT_TRUE(wait_until([&] { return is_near(v, 0.3); }));
  EXPECT_NE(set("/teleop", "joy_timeout", 5.0).find("read-only"), std::string::npos);
}

}  // namespace
}  // namespace tandem::test
