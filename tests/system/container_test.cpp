// SPDX-License-Identifier: Apache-2.0
// Tests `tandem container` in its own process, with the requests of `ros2 component`.
#include <algorithm>
#include <csignal>
#include <memory>
#include <vector>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

using composition_interfaces::srv::ListNodes_Response;
using composition_interfaces::srv::LoadNode_Request;
using composition_interfaces::srv::LoadNode_Response;
using composition_interfaces::srv::UnloadNode_Request;
using composition_interfaces::srv::UnloadNode_Response;

namespace composition = composition_interfaces::srv;

constexpr double kLoading = 30.0;  // [s] for a slow machine under a sanitizer

rcl_interfaces::msg::Parameter parameter(const std::string& name, double value) {
  rcl_interfaces::msg::Parameter parameter;
  parameter.name(name);
  parameter.value().type(rcl_interfaces::msg::ParameterType_Constants::PARAMETER_DOUBLE);
  parameter.value().double_value(value);
  return parameter;
}

class ContainerOverDds : public testing::Test {
 protected:
  static LoadNode_Request arbitration() {
    LoadNode_Request request;
    request.package_name("tandem_arbitration");
    request.plugin_name("tandem::Arbitration");
    return request;
  }

  template <class S>
  typename S::Response ask(const rt::Client<S>& client, const typename S::Request& request) {
    std::optional<typename S::Response> answer;
    client.call(
        request, [&](const auto& response) { answer = response; }, kLoading);
    EXPECT_TRUE(spin_until([&] { return answer.has_value(); }, kLoading, node_));
    return answer.value_or(typename S::Response{});
  }
  LoadNode_Response load(const LoadNode_Request& request) { return ask(load_, request); }
  UnloadNode_Response unload(std::uint64_t id) {
    UnloadNode_Request request;
    request.unique_id(id);
    return ask(unload_, request);
  }
  ListNodes_Response list() { return ask(list_, {}); }

  void expect_refused(const LoadNode_Request& request, const std::string& reason) {
    const auto answer = load(request);
    EXPECT_FALSE(answer.success());
    EXPECT_NE(answer.error_message().find(reason), std::string::npos) << answer.error_message();
  }

  // Where a third party's module lies, besides Tandem's own.
  const int environment_ = setenv("TANDEM_COMPONENT_PATH", binary_path("tests").c_str(), 1);
  ChildProcess container_{"../tandem", {"container"}};
  rt::Node node_{"tester"};
  rt::Client<composition::LoadNode> load_ = node_.create_client(
      rt::ServiceName<composition::LoadNode>{"/tandem_container/_container/load_node"});
  rt::Client<composition::UnloadNode> unload_ = node_.create_client(
      rt::ServiceName<composition::UnloadNode>{"/tandem_container/_container/unload_node"});
  rt::Client<composition::ListNodes> list_ = node_.create_client(
      rt::ServiceName<composition::ListNodes>{"/tandem_container/_container/list_nodes"});
};

TEST_F(ContainerOverDds, LoadsListsAndUnloadsWithNamesRemapsAndParameters) {
  auto request = arbitration();
  request.node_name("judge");
  request.node_namespace("/chair");
  request.remap_rules({"cmd_vel_user:=/stick"});
  request.parameters({parameter("user_timeout", 0.25)});
  const auto loaded = load(request);
  ASSERT_TRUE(loaded.success()) << loaded.error_message();
  EXPECT_EQ(loaded.full_node_name(), "/chair/judge");
  EXPECT_EQ(loaded.unique_id(), 1U);

  const auto stick = node_.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{"/stick"});
  EXPECT_TRUE(spin_until([&] { return stick.matched() == 1; }, kLoading, node_));

  ASSERT_TRUE(load(arbitration()).success());
  const auto both = list();
  EXPECT_EQ(both.full_node_names(), (std::vector<std::string>{"/chair/judge", "/arbitration"}));
  EXPECT_EQ(both.unique_ids(), (std::vector<std::uint64_t>{1, 2}));

  EXPECT_TRUE(unload(1).success());
  EXPECT_TRUE(spin_until([&] { return stick.matched() == 0; }, kLoading, node_));
  EXPECT_EQ(list().full_node_names(), (std::vector<std::string>{"/arbitration"}));
  EXPECT_TRUE(load(request).success());  // the name is free again
}

TEST_F(ContainerOverDds, AnswersBadRequestsWithTheReasonAndGoesOn) {
  auto request = arbitration();
  request.plugin_name("tandem::Nonsense");
  request.package_name("tandem");
  expect_refused(request, "unknown component 'nonsense'; in ");
  request.plugin_name("tandem::Arbitraton");
  expect_refused(request, "unknown component 'arbitraton'; did you mean `arbitration`?");
  request = arbitration();
  request.package_name("tandem_teleop");
  expect_refused(request, "package 'tandem_teleop' has no plugin 'tandem::Arbitration'");
  request.package_name("composition");
  expect_refused(
      request,
      "package 'composition' has no plugin 'tandem::Arbitration'; package 'tandem' has it");
  request = arbitration();
  request.parameters({parameter("user_timeuot", 1.0)});
  expect_refused(request, "user_timeuot");
  request.parameters({parameter("user_timeout", -1.0)});
  expect_refused(request, "load_node: node /arbitration: user_timeout = -1 outside");
  request.parameters({rcl_interfaces::msg::Parameter{}});
  expect_refused(request, "no parameter here is unset");
  request = arbitration();
  request.remap_rules({"cmd_vel_user"});
  expect_refused(request, "'cmd_vel_user' is not of the form name:=value");
  request = arbitration();
  request.node_name("9");
  expect_refused(request, "9");
  request = arbitration();
  request.extra_arguments({parameter("use_magic", 1.0)});
  expect_refused(request, "extra argument 'use_magic'");

  ASSERT_TRUE(load(arbitration()).success());
  expect_refused(arbitration(), "/arbitration");  // the name is taken
  const auto unknown = unload(7);
  EXPECT_FALSE(unknown.success());
  EXPECT_EQ(unknown.error_message(), "No node found with unique_id: 7");
  EXPECT_EQ(list().full_node_names(), (std::vector<std::string>{"/arbitration"}));
}

TEST_F(ContainerOverDds, LoadsTheModulesOfAThirdPartysPackage) {
  LoadNode_Request request;
  request.package_name("test_component");
  request.plugin_name("third_party::TestComponent");
  const auto loaded = load(request);
  ASSERT_TRUE(loaded.success()) << loaded.error_message();
  EXPECT_EQ(loaded.full_node_name(), "/test_component");
  request.package_name("tandem");
  expect_refused(request, "package 'test_component' has it");
}

// Any program on the bus may call load_node, which must not open files elsewhere.
TEST_F(ContainerOverDds, RefusesNamesThatAreNoNamesOfPackagesAndPlugins) {
  const std::string error = ": a name consists of a-z, 0-9 and _";
  auto request = arbitration();
  for (const auto& name :
       {std::string{"../../x"}, std::string{"/tmp/x"}, std::string{}, std::string(300, 'a')}) {
    request = arbitration();
    request.plugin_name(name);
    expect_refused(request, error);
    request = arbitration();
    request.package_name(name);
    expect_refused(request, error);
  }
  EXPECT_TRUE(load(arbitration()).success());
}

TEST_F(ContainerOverDds, EndsAtASignalWithItsComponents) {
  ASSERT_TRUE(load(arbitration()).success());
  container_.send(SIGTERM);
  EXPECT_EQ(container_.wait(kLoading), 0);
}

}  // namespace
}  // namespace tandem::test
