// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/component.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;
using test::spin_until;

constexpr double kTimeout = 10.0;  // [s]

TEST(Component, RunsFromItsLibraryWithParametersAndRemappings) {
  rt::NodeOptions options{.name = "tripler", .ns = "/a", .remappings = {{"out", "/result"}}};
  options.parameters.values["factor"] = {"3.0", "test"};
  const auto component = rt::load_component("test_component", options);
  rt::Node node{"user"};
  double result = 0.0;
  const auto in = node.create_publisher(rt::Topic<Float64>{"/a/in"});
  const auto out = node.create_subscription(rt::Topic<Float64>{"/result"},
                                            [&](const Float64& m) { result = m.data(); });
  ASSERT_TRUE(spin_until([&] { return in.matched() == 1 && out.matched() == 1; }, kTimeout, node));
  Float64 message;
  message.data(7.0);
  in.publish(message);
  EXPECT_TRUE(spin_until([&] { return result == 21.0; }, kTimeout, node));
}

TEST(Component, MayBeLoadedTwiceUnderTwoNames) {
  const auto first = rt::load_component("test_component", {.name = "one"});
  const auto second = rt::load_component("test_component", {.name = "two"});
  EXPECT_EQ(second.node().fully_qualified_name(), "/two");
}

TEST(Component, UnknownIsRefusedWithTheListOfKnownOnes) {
  try {
    const auto component = rt::load_component("nonsense", {.name = "x"});
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("nonsense"), std::string::npos) << text;
    EXPECT_NE(text.find("test_component"), std::string::npos) << text;
  }
}

TEST(Component, WithAnUnknownParameterIsRefused) {
  rt::NodeOptions options{.name = "wrong"};
  options.parameters.values["facter"] = {"3.0", "test"};
  EXPECT_THROW((void)rt::load_component("test_component", options), std::invalid_argument);
}

TEST(Component, IsListed) {
  const auto names = rt::list_components();
  EXPECT_EQ(std::count(names.begin(), names.end(), "test_component"), 1);
}

}  // namespace
}  // namespace tandem
