// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/component.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/extension.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;
using test::spin_until;

using test::kTimeout;

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

// The error of loading that component; empty if it is loaded.
std::string refusal_of(const std::string& component) {
  try {
    (void)rt::description_of(component);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(Component, OfAnotherVersionIsRefusedBeforeItsCodeRuns) {
  const std::string text = refusal_of("outdated");
  EXPECT_NE(text.find("libtandem_outdated.so was built for Tandem 0.1, this is Tandem " +
                      std::string{TANDEM_ABI_VERSION} + "; rebuild it"),
            std::string::npos)
      << text;
  EXPECT_EQ(std::getenv("TANDEM_REFUSED_MODULE_HAS_RUN"), nullptr);
}

TEST(Component, WithoutAMarkIsRefusedBeforeItsCodeRuns) {
  const std::string text = refusal_of("unmarked");
  EXPECT_NE(text.find("libtandem_unmarked.so is not a module of Tandem"), std::string::npos)
      << text;
  EXPECT_EQ(std::getenv("TANDEM_REFUSED_MODULE_HAS_RUN"), nullptr);
}

TEST(Component, ThatCannotBeLoadedIsNotListed) {
  const auto names = rt::list_components();
  EXPECT_EQ(std::count(names.begin(), names.end(), "outdated"), 0);
  EXPECT_EQ(std::count(names.begin(), names.end(), "unmarked"), 0);
}

// Whatever a module's first bytes say, reading its mark neither crashes nor runs it.
TEST(Component, WhoseFileIsCutOffIsRefused) {
  const std::filesystem::path whole{test::binary_path("tests/libtandem_test_component.so")};
  const auto cut = std::filesystem::path{test::binary_path("tests")} / "libtandem_cut_off.so";
  std::ifstream in{whole, std::ios::binary};
  const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
  ASSERT_GT(bytes.size(), 1000u);
  for (const std::size_t size : {0, 3, 16, 64, 100, 500}) {
    std::ofstream{cut, std::ios::binary}.write(bytes.data(), static_cast<std::streamsize>(size));
    EXPECT_NE(refusal_of("cut_off").find("is not a module of Tandem"), std::string::npos) << size;
  }
  std::filesystem::remove(cut);
}

std::string complaint_about(const std::string& extension) {
  try {
    (void)rt::function_of_extension(extension, "no_such_function");
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(Extension, IsNamedWithTheRemedyIfItCannotBeUsed) {
  const auto broken = std::filesystem::path{test::binary_path("tests")} / "libtandem-broken.so";
  std::ofstream{broken} << "text";
  for (const auto& [name, fault] :
       {std::pair{"absent", "libtandem-absent.so is in none of"},
        std::pair{"broken", "libtandem-broken.so"}, std::pair{"outdated", "is of Tandem 0.0.1"},
        std::pair{"empty", "no_such_function"}}) {
    const std::string text = complaint_about(name);
    EXPECT_NE(text.find(fault), std::string::npos) << text;
    EXPECT_NE(text.find("install Tandem again"), std::string::npos) << text;
  }
  EXPECT_EQ(complaint_about("broken").find("is in none of"), std::string::npos);
  std::filesystem::remove(broken);
}

TEST(Component, NameThatIsNoFileNameIsRefused) {
  for (const std::string& name :
       {std::string{"../../x"}, std::string{"/tmp/x"}, std::string{}, std::string(300, 'a'),
        std::string{"Teleop"}, std::string{"a\nb"}})
    EXPECT_NE(refusal_of(name).find("a name consists of a-z, 0-9 and _"), std::string::npos)
        << name;
}

TEST(Component, BelongsToAPackage) {
  EXPECT_EQ(rt::package_of("test_component"), "test_component");
}

TEST(Component, FoldersDoNotChangeAfterTheStart) {
  const auto before = rt::component_folders();
  setenv("TANDEM_COMPONENT_PATH", "/tmp", 1);
  EXPECT_EQ(rt::component_folders(), before);
  unsetenv("TANDEM_COMPONENT_PATH");
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

TEST(Component, IsDescribedByItsModule) {
  const auto description = rt::description_of("test_component");
  EXPECT_EQ(description.name, "test_component");
  ASSERT_EQ(description.parameters.size(), 1u);
  const rt::Field& factor = description.parameters.front();
  EXPECT_EQ(factor.name, "factor");
  EXPECT_EQ(rt::to_text(value_of(factor)), "2");
  EXPECT_EQ(std::get<Range>(factor.limits).max, 10.0);
  ASSERT_EQ(description.interface.subscribes.size(), 1u);
  ASSERT_EQ(description.interface.publishes.size(), 1u);
  const rt::TopicUse& out = description.interface.publishes.front();
  EXPECT_EQ(out.name, "out");
  EXPECT_EQ(out.type, "std_msgs/msg/Float64");
  EXPECT_EQ(out.qos, rt::kLatched);
  EXPECT_EQ(to_text(out.qos), "reliable, transient local, depth 1");
}

TEST(Component, IsNotTheRuntimeItself) {
  try {
    (void)rt::package_of("runtime");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_TRUE(std::string{error.what()}.starts_with("'runtime' is no component: "))
        << error.what();
  }
}

TEST(Component, ThatIsUnknownHasNoDescription) {
  EXPECT_THROW((void)rt::description_of("nonsense"), std::invalid_argument);
}

// The error of a check with these values; empty if they are accepted.
std::string error_of(const std::map<std::string, std::string>& values) {
  rt::NodeOptions options{.name = "x"};
  for (const auto& [key, value] : values) options.parameters.values[key] = {value, "here:7"};
  try {
    rt::check_parameters("test_component", options);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(ComponentParameters, AreCheckedWithoutRunningTheComponent) {
  EXPECT_EQ(error_of({{"factor", "3"}, {"use_sim_time", "true"}}), "");
  EXPECT_EQ(error_of({{"qos_overrides./in.subscription.reliability", "best_effort"}}), "");
  EXPECT_EQ(error_of({{"facter", "3"}}),
            "here:7: node /x: facter = 3 is not a parameter of this node; did you mean `factor`?");
  EXPECT_EQ(error_of({{"speed", "3"}}),
            "here:7: node /x: speed = 3 is not a parameter of this node");
  EXPECT_NE(error_of({{"factor", "11"}}).find("here:7: node /x: factor = 11 outside [0, 10]"),
            std::string::npos);
}

struct HiddenParams {
  double hidden = 1.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("hidden", hidden, Range{0.0, 1.0}, "a parameter of no description");
  }
};

// Lacks `using Params = HiddenParams;`.
class Undescribed {
 public:
  explicit Undescribed(rt::Node& node) : params_{node.declare_parameters<HiddenParams>()} {}
  static rt::Interface interface() { return {}; }

 private:
  rt::Parameters<HiddenParams> params_;
};

TEST(Component, ThatDescribesNotAllOfItsParametersIsRefused) {
  rt::register_component("undescribed", rt::component_of<Undescribed>());
  try {
    const auto component = rt::load_component("undescribed", {.name = "x"});
    FAIL() << "no exception";
  } catch (const std::logic_error& error) {
    EXPECT_NE(std::string{error.what()}.find("`hidden`"), std::string::npos) << error.what();
  }
}

TEST(Interfaces, AreJoinedAndGetConditions) {
  constexpr rt::Topic<Float64> a{"a"}, b{"b"}, c{"c"};
  const rt::Interface rare = only_if("x: 1", rt::Interface{.subscribes = {a, {b, "y: 2"}}});
  const rt::Interface all = rt::Interface{.publishes = {c}, .other_input = "a file"} + rare +
                            rt::Interface{.other_input = "a device"};
  ASSERT_EQ(all.subscribes.size(), 2u);
  EXPECT_EQ(all.subscribes[0].condition, "x: 1");
  EXPECT_EQ(all.subscribes[1].condition, "x: 1, y: 2");
  ASSERT_EQ(all.publishes.size(), 1u);
  EXPECT_EQ(all.publishes[0].condition, "");
  EXPECT_EQ(all.other_input, "a file, a device");
}

}  // namespace
}  // namespace tandem
