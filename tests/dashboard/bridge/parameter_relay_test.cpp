// SPDX-License-Identifier: Apache-2.0
// Tests how web clients read and set parameters of the domain's nodes.
#include "tandem/dashboard/bridge/parameter_relay.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dashboard/bridge/page_client.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using foxglove::json;

struct TargetParams {
  double gain = 1.0;
  int count = 3;
  bool enabled = true;
  std::string name = "left";
  std::vector<double> route = {1.5, 2.0};

  template <class Visitor>
  void visit(Visitor&& field) {
    field("gain", gain, Range{0.0, 5.0}, "of the stick");
    field("count", count, Range{0, 9}, "how many");
    field("enabled", enabled, "whether");
    field("name", name, "which");
    field("route", route, Range{-9.0, 9.0}, "where");
  }
};

class ParameterRelayOverDds : public testing::Test {
 protected:
  ParameterRelayOverDds() {
    EXPECT_TRUE(spin_until([&] {
      for (const auto& service : dashboard_.services())
        if (service.name == "/a/target/list_parameters") return true;
      return false;
    }));
    relay_.begin_beat();
  }
  template <class Done>
  bool spin_until(Done done) {
    return test::spin_until(done, test::kTimeout, dashboard_, target_);
  }
  // The relay answers when the last of the requests that it made is answered.
  json values_of(const std::vector<std::string>& names) {
    relay_.get(page_.id(), {names, "get"});
    return answer();
  }
  json set(const std::string& name, const json& value, const std::string& type = "") {
    relay_.set(page_.id(), {{{name, value, type}}, "set"});
    return answer();
  }
  json answer() {
    EXPECT_TRUE(spin_until([&] { return page_.has_frame(); }));
    return page_.read_json();
  }

  rt::Node dashboard_{"dashboard"};
  rt::Node target_{rt::NodeOptions{.name = "target", .ns = "/a"}};
  rt::Parameters<TargetParams> params_ = target_.declare_parameters<TargetParams>(
      {}, [](TargetParams& params) -> TargetParams& { return params; }, [](const auto&) {});
  test::PageClient page_;
  ParameterRelay relay_{dashboard_, page_.web()};
};

TEST_F(ParameterRelayOverDds, GivesEachTypeInItsJsonForm) {
  const json answer = values_of({"/a/target.gain", "/a/target.count", "/a/target.enabled",
                                 "/a/target.name", "/a/target.route", "/a/target.unknown"});
  EXPECT_EQ(answer.at("id"), "get");
  const json expected = {
      {{"name", "/a/target.gain"}, {"value", 1.0}, {"type", "float64"}},
      {{"name", "/a/target.count"}, {"value", 3}},
      {{"name", "/a/target.enabled"}, {"value", true}},
      {{"name", "/a/target.name"}, {"value", "left"}},
      {{"name", "/a/target.route"}, {"value", {1.5, 2.0}}, {"type", "float64_array"}}};
  EXPECT_EQ(answer.at("parameters"), expected);
}

TEST_F(ParameterRelayOverDds, SetsEachTypeAndAnswersWithTheValueInForce) {
  EXPECT_EQ(set("/a/target.gain", 2, "float64").at("parameters").at(0).at("value"), 2.0);
  EXPECT_EQ(set("/a/target.count", 7).at("parameters").at(0).at("value"), 7);
  EXPECT_EQ(set("/a/target.enabled", false).at("parameters").at(0).at("value"), false);
  EXPECT_EQ(set("/a/target.name", "right").at("parameters").at(0).at("value"), "right");
  (void)set("/a/target.route", {3, 4}, "float64_array");
  EXPECT_EQ(params_->gain, 2.0);
  EXPECT_EQ(params_->count, 7);
  EXPECT_FALSE(params_->enabled);
  EXPECT_EQ(params_->name, "right");
  EXPECT_EQ(params_->route, (std::vector<double>{3.0, 4.0}));
}

TEST_F(ParameterRelayOverDds, ReportsWhyAParameterWasNotSet) {
  const json out_of_range = set("/a/target.gain", 99.0);
  EXPECT_EQ(out_of_range.at("op"), "status");
  EXPECT_NE(out_of_range.at("message").get<std::string>().find("gain"), std::string::npos);
  EXPECT_EQ(page_.read_json().at("parameters").at(0).at("value"), 1.0) << "the old value";
  EXPECT_EQ(set("/nobody.gain", 1.0).at("message"), "there is no node /nobody");
  EXPECT_EQ(page_.read_json().at("parameters"), json::array());
  EXPECT_NE(set("/a/target.gain", json::object())
                .at("message")
                .get<std::string>()
                .find("not a parameter value"),
            std::string::npos);
}

TEST_F(ParameterRelayOverDds, RefusesTooManyNamesInOneRequest) {
  relay_.get(page_.id(),
             {std::vector<std::string>(ParameterRelay::kMaxNames + 1, "/a/target.gain"), "many"});
  EXPECT_NE(page_.read_json().at("message").get<std::string>().find("at most 1000"),
            std::string::npos);
}

TEST_F(ParameterRelayOverDds, ReportsChangesOfWatchedParametersOnly) {
  relay_.subscribe(page_.id(), {{"/a/target.gain"}, true});
  EXPECT_EQ(set("/a/target.count", 5).at("parameters").at(0).at("name"), "/a/target.count");
  // The answer and the change, in any order; a report on `count` would come before them.
  for (const json& frame : {set("/a/target.gain", 1.5), answer()}) {
    ASSERT_EQ(frame.at("parameters").size(), 1U);
    EXPECT_EQ(frame.at("parameters").at(0).at("name"), "/a/target.gain");
  }
}

}  // namespace
}  // namespace tandem
