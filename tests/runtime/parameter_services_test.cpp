// SPDX-License-Identifier: Apache-2.0
// Tests access to a node's parameters over DDS, as `ros2 param` does it.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using rcl_interfaces::msg::Parameter;
using rcl_interfaces::msg::ParameterEvent;
namespace srv = rcl_interfaces::srv;
namespace types = rcl_interfaces::msg::ParameterType_Constants;
using test::spin_until;

using test::kTimeout;

struct DriveParams {
  double gain = 1.0;
  bool enabled = true;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("gain", gain, Range{0.0, 2.0}, "[1] of the stick");
    field("enabled", enabled, "whether");
  }
};

struct LateParams {
  int count = 3;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("count", count, Range{0, 9}, "how many");
  }
};

Parameter gain(double value) {
  Parameter parameter;
  parameter.name("gain");
  parameter.value().type(types::PARAMETER_DOUBLE);
  parameter.value().double_value(value);
  return parameter;
}

class ParameterServices : public testing::Test {
 protected:
  // The node's answer to one request.
  template <class S>
  typename S::Response ask(const char* service, const typename S::Request& request) {
    const auto client = tool_.create_client(rt::ServiceName<S>{service});
    std::optional<typename S::Response> answer;
    client.call(
        request, [&](const auto& response) { answer = response; }, kTimeout);
    EXPECT_TRUE(spin_until([&] { return answer.has_value(); }, kTimeout, node_, tool_)) << service;
    return answer.value_or(typename S::Response{});
  }

  double get_gain() {
    srv::GetParameters::Request request;
    request.names({"gain"});
    const auto values = ask<srv::GetParameters>("/robot/drive/get_parameters", request).values();
    return values.size() == 1 ? values[0].double_value() : -1.0;
  }

  auto set(std::vector<Parameter> parameters) {
    srv::SetParameters::Request request;
    request.parameters(std::move(parameters));
    return ask<srv::SetParameters>("/robot/drive/set_parameters", request).results();
  }

  rt::Node node_{rt::NodeOptions{.name = "drive", .ns = "/robot"}};
  rt::Node tool_{rt::NodeOptions{.name = "tool", .serves_tools = false}};
  rt::Parameters<DriveParams> params_ = node_.declare_parameters<DriveParams>(
      {}, [](auto& all) -> auto& { return all; }, [](const auto&) {});
};

TEST_F(ParameterServices, GetAndSetANumber) {
  EXPECT_EQ(get_gain(), 1.0);
  const auto results = set({gain(1.5)});
  ASSERT_EQ(results.size(), 1U);
  EXPECT_TRUE(results[0].successful());
  EXPECT_EQ(params_->gain, 1.5);
  EXPECT_EQ(get_gain(), 1.5);
}

TEST_F(ParameterServices, SetEachForItselfButAtomicallyAllOrNone) {
  const auto results = set({gain(9.0), gain(1.25)});
  ASSERT_EQ(results.size(), 2U);
  EXPECT_FALSE(results[0].successful());
  EXPECT_NE(results[0].reason().find("[0, 2]"), std::string::npos) << results[0].reason();
  EXPECT_TRUE(results[1].successful());
  EXPECT_EQ(params_->gain, 1.25);

  srv::SetParametersAtomically::Request request;
  request.parameters({gain(0.5), gain(9.0)});
  const auto answer =
      ask<srv::SetParametersAtomically>("/robot/drive/set_parameters_atomically", request);
  EXPECT_FALSE(answer.result().successful());
  EXPECT_EQ(params_->gain, 1.25);
}

TEST_F(ParameterServices, ListDescribeAndNameTypes) {
  const auto list = ask<srv::ListParameters>("/robot/drive/list_parameters", {}).result();
  const std::string events = "qos_overrides./parameter_events.publisher.";
  EXPECT_EQ(list.names(),
            (std::vector<std::string>{
                "use_sim_time", "start_type_description_service", "service_configure_introspection",
                "client_configure_introspection", "action_server_configure_introspection",
                "action_client_configure_introspection", events + "reliability",
                events + "durability", events + "depth", events + "history", "gain", "enabled"}));

  srv::DescribeParameters::Request describe;
  describe.names({"gain", "start_type_description_service"});
  const auto descriptors =
      ask<srv::DescribeParameters>("/robot/drive/describe_parameters", describe).descriptors();
  ASSERT_EQ(descriptors.size(), 2U);
  EXPECT_EQ(descriptors[0].description(), "[1] of the stick");
  EXPECT_FALSE(descriptors[0].read_only());
  EXPECT_TRUE(descriptors[1].read_only());

  srv::GetParameterTypes::Request name_types;
  name_types.names({"enabled", "nobody"});
  EXPECT_EQ(ask<srv::GetParameterTypes>("/robot/drive/get_parameter_types", name_types).types(),
            (std::vector<std::uint8_t>{types::PARAMETER_BOOL, types::PARAMETER_NOT_SET}));
}

TEST_F(ParameterServices, ChangeTheTimeSourceOfARunningNode) {
  rt::Node source{"clock_source"};
  const auto clock =
      source.create_publisher(rt::Topic<rosgraph_msgs::msg::Clock>{"/clock", rt::kClock});
  const auto set_use_sim_time = [&](bool value) {
    Parameter parameter;
    parameter.name("use_sim_time");
    parameter.value().type(types::PARAMETER_BOOL);
    parameter.value().bool_value(value);
    return set({parameter}).at(0);
  };
  int jumps = 0;
  const auto jump = node_.on_time_jump([&] { ++jumps; });
  EXPECT_TRUE(set_use_sim_time(true).successful());
  EXPECT_TRUE(node_.use_sim_time());
  EXPECT_EQ(node_.now(), 0.0);
  EXPECT_EQ(jumps, 1);
  rosgraph_msgs::msg::Clock time;
  time.clock(rt::to_stamp(12'500'000'000));
  ASSERT_TRUE(spin_until(
      [&] {
        clock.publish(time);
        return node_.now() == 12.5;
      },
      kTimeout, node_));
  EXPECT_TRUE(set_use_sim_time(false).successful());
  EXPECT_EQ(jumps, 2);
  EXPECT_NEAR(node_.now(), node_.steady_now(), 1.0);
  EXPECT_TRUE(spin_until([&] { return clock.matched() == 0; }, kTimeout, node_));
  node_.fix_common_parameters();
  EXPECT_EQ(set_use_sim_time(true).reason(),
            "parameter 'use_sim_time' cannot be set because it is read-only");
  EXPECT_FALSE(node_.use_sim_time());
}

TEST(StartTypeDescriptionService, AsAParameterDecidesWhetherItIsServed) {
  rt::NodeOptions options{.name = "silent"};
  options.parameters.values["start_type_description_service"] = {"false", "test"};
  rt::Node silent{options}, usual{"usual"}, tool{"tool"};
  const auto served = [&](const std::string& name) {
    const auto all = tool.services();
    return std::any_of(all.begin(), all.end(), [&](const auto& info) { return info.name == name; });
  };
  EXPECT_TRUE(spin_until(
      [&] { return served("/usual/get_type_description") && served("/silent/list_parameters"); },
      kTimeout, tool));
  EXPECT_FALSE(served("/silent/get_type_description"));
}

TEST_F(ParameterServices, AnswerNothingToTooManyNames) {
  srv::GetParameters::Request request;
  request.names(std::vector<std::string>(5000, "g"));
  EXPECT_TRUE(ask<srv::GetParameters>("/robot/drive/get_parameters", request).values().empty());
  EXPECT_EQ(get_gain(), 1.0);
}

// Nodes of a process are made one after the other; all of them hear what each has declared.
TEST_F(ParameterServices, PublishDeclaredParametersOnceTheNodeSpins) {
  std::vector<ParameterEvent> events;
  const auto subscription =
      tool_.create_subscription(rt::Topic<ParameterEvent>{"/parameter_events"},
                                [&](const auto& event) { events.push_back(event); });
  const auto is_announced = [&] {
    return std::any_of(events.begin(), events.end(), [](const ParameterEvent& event) {
      return event.node() == "/robot/drive" && event.new_parameters().size() > 1;
    });
  };
  EXPECT_TRUE(spin_until(is_announced, kTimeout, node_, tool_));
}

TEST_F(ParameterServices, PublishChangesOnParameterEvents) {
  node_.spin_some(0.0);  // announces what is declared
  std::vector<ParameterEvent> events;
  const auto subscription =
      tool_.create_subscription(rt::Topic<ParameterEvent>{"/parameter_events"},
                                [&](const auto& event) { events.push_back(event); });
  ASSERT_TRUE(spin_until([&] { return subscription.matched() == 1; }, kTimeout, node_, tool_));
  EXPECT_FALSE(set({gain(9.0)})[0].successful());
  EXPECT_TRUE(set({gain(0.75)})[0].successful());
  ASSERT_TRUE(spin_until([&] { return !events.empty(); }, kTimeout, node_, tool_));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].node(), "/robot/drive");
  ASSERT_EQ(events[0].changed_parameters().size(), 1U);
  EXPECT_EQ(events[0].changed_parameters()[0].value().double_value(), 0.75);
  EXPECT_TRUE(events[0].new_parameters().empty());
  EXPECT_GT(events[0].stamp().sec(), 0);
}

TEST_F(ParameterServices, PublishParametersDeclaredLater) {
  node_.spin_some(0.0);
  std::vector<ParameterEvent> events;
  const auto subscription =
      tool_.create_subscription(rt::Topic<ParameterEvent>{"/parameter_events"},
                                [&](const auto& event) { events.push_back(event); });
  ASSERT_TRUE(spin_until([&] { return subscription.matched() == 1; }, kTimeout, node_, tool_));
  const auto late = node_.declare_parameters<LateParams>();
  ASSERT_TRUE(spin_until([&] { return !events.empty(); }, kTimeout, node_, tool_));
  ASSERT_EQ(events[0].new_parameters().size(), 1U);
  EXPECT_EQ(events[0].new_parameters()[0].value().integer_value(), 3);
}

}  // namespace
}  // namespace tandem
