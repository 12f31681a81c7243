// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameter_table.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <stdexcept>

namespace tandem {

namespace rt = runtime;

namespace {

using rcl_interfaces::msg::Parameter;
using rcl_interfaces::msg::ParameterValue;
namespace types = rcl_interfaces::msg::ParameterType_Constants;
using Names = std::vector<std::string>;

struct TableParams {
  double margin = 0.1;
  double margin_max = 0.5;
  int steps = 5;
  bool enforce = true;
  std::string mode = "shared";
  std::string map = "";
  std::vector<double> outline{1.0, 2.0};

  template <class Visitor>
  void visit(Visitor&& field) {
    field("margin", margin, Range{0.0, 1.0}, "[m] gap");
    field("margin_max", margin_max, Range{0.0, 1.0}, "[m] largest gap");
    field("steps", steps, Range{1, 50}, "how many");
    field("enforce", enforce, "whether");
    field("mode", mode, OneOf{{"manual", "shared"}}, "who drives");
    field("map", map, "file");
    field("outline", outline, Range{-5.0, 5.0}, "[m] its corners");
  }
};

struct FrameParams {
  std::string odom = "odom";
  double left = 1.0, right = 2.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("frames.odom", odom, "where odometry begins");
    field("wheels.left.radius", left, Range{0.0, 5.0}, "[m]");
    field("wheels.right.radius", right, Range{0.0, 5.0}, "[m]");
  }
};

struct TwoOfOneName {
  double gap = 0.1, silence = 0.2;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("timeout", gap, Range{0.0, 1.0}, "[s] one thing");
    field("timeout", silence, Range{0.0, 1.0}, "[s] another");
  }
};

struct Both {
  TableParams gate;
  FrameParams frames;

  template <class Visitor>
  void visit(Visitor&& field) {
    gate.visit(field);
    frames.visit(field);
  }
};

ParameterValue value(const std::string& yaml) { return rt::value_from_yaml(yaml); }

Parameter parameter(const std::string& name, const ParameterValue& value) {
  Parameter result;
  result.name(name);
  result.value(value);
  return result;
}

ParameterValue empty_list(std::uint8_t type) {
  ParameterValue list;
  list.type(type);
  return list;
}

// TableParams may change while margin ≤ margin_max; FrameParams may not change.
class Table : public testing::Test {
 protected:
  void SetUp() override {
    table_.declare(rt::make_group<TableParams>(gate_, rt::names_of(*gate_), [this](const auto& p) {
      if (p.margin > p.margin_max) throw std::invalid_argument("margin exceeds margin_max");
      offered_ = p;
    }));
    table_.declare(rt::make_fixed_group(frames_));
  }

  // The error message for setting them all at once; "" if they were set.
  std::string set(const std::vector<Parameter>& parameters) {
    const auto result = table_.set(parameters);
    EXPECT_EQ(result.successful(), result.reason().empty());
    return result.reason();
  }
  std::string set(const std::string& name, const std::string& yaml) {
    return set({parameter(name, value(yaml))});
  }

  std::shared_ptr<TableParams> gate_ = std::make_shared<TableParams>();
  std::shared_ptr<FrameParams> frames_ = std::make_shared<FrameParams>();
  std::optional<TableParams> offered_;
  rt::ParameterTable table_;
};

struct Assignment {
  const char *name, *yaml;
  std::vector<std::string> complaint;  // parts of it; none: accepted
};

class SetParameter : public Table, public testing::WithParamInterface<Assignment> {};

TEST_P(SetParameter, IsTakenOrRefusedWithTheReason) {
  const auto& [name, yaml, complaint] = GetParam();
  const auto before = table_.get({name});
  const std::string reason = set(name, yaml);
  EXPECT_EQ(reason.empty(), complaint.empty()) << reason;
  EXPECT_EQ(offered_.has_value(), complaint.empty());
  for (const auto& part : complaint) EXPECT_NE(reason.find(part), std::string::npos) << reason;
  if (!complaint.empty()) {
    EXPECT_EQ(table_.get({name}), before);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Values, SetParameter,
    testing::Values(
        Assignment{"margin", "0.25", {}}, Assignment{"margin", "0", {}},  // an integer will do
        Assignment{"margin",
                   "1.5",
                   {"Parameter {margin} doesn't comply with floating point range. ", "margin = 1.5",
                    "[0, 1]", "[m] gap"}},
        Assignment{"margin", "-0.001", {"margin", "[0, 1]"}},
        Assignment{"margin", ".nan", {"margin", "nan", "[0, 1]"}},
        Assignment{"margin", "!!float 0", {}}, Assignment{"margin", "!!float 5e-1", {}},
        Assignment{"margin", "!!str 0.5", {"{double}", "{string}"}},
        Assignment{"margin", "!!float half", {"cannot undeclare"}},
        Assignment{"steps", "!!int 7", {}},
        Assignment{"steps", "!!float 7", {"{integer}", "{double}"}},
        Assignment{"enforce", "!!bool yes", {}}, Assignment{"map", "!!str 7", {}},
        Assignment{"map", "!!binary Zm9v", {"cannot undeclare"}},
        Assignment{"outline", "[!!float 1, !!float 2]", {}},
        Assignment{"margin", ".inf", {"margin", "inf", "[0, 1]"}},
        Assignment{"margin",
                   "\"0.5\"",
                   {"Wrong parameter type, parameter {margin} is of type {double}, setting it to "
                    "{string} is not allowed."}},
        Assignment{"margin", "true", {"{margin} is of type {double}", "to {bool}"}},
        Assignment{"margin", "[0.5]", {"{double}", "{double_array}"}},
        Assignment{"margin", "~", {"cannot undeclare a statically typed parameter"}},
        Assignment{"margin", "0.6", {"margin exceeds margin_max"}}, Assignment{"steps", "50", {}},
        Assignment{"steps", "51", {"{steps} doesn't comply with integer range", "51", "[1, 50]"}},
        Assignment{"steps", "2.5", {"{steps}", "{integer}", "{double}"}},
        Assignment{"steps", "5000000000", {"steps", "5000000000", "not an integer"}},
        Assignment{"enforce", "false", {}},
        Assignment{"enforce", "0", {"{enforce}", "{bool}", "{integer}"}},
        Assignment{"mode", "manual", {}},
        Assignment{"mode", "auto", {"mode", "auto", "manual, shared", "who drives"}},
        Assignment{"mode", "1", {"{mode}", "{string}", "{integer}"}},
        Assignment{"map", "\"7\"", {}}, Assignment{"map", "7", {"{map}", "{string}", "{integer}"}},
        Assignment{"outline", "[0.5, -1]", {}}, Assignment{"outline", "[]", {}},
        Assignment{"outline", "[0, 9]", {"outline", "9", "[-5, 5]"}},
        Assignment{"outline", "[a]", {"{outline}", "{double_array}", "{string_array}"}},
        Assignment{"outline", "1.0", {"{outline}", "{double_array}", "{double}"}},
        Assignment{"margn", "0.2", {"parameter 'margn' cannot be set because it was not declared"}},
        Assignment{"", "0.2", {"was not declared"}},
        Assignment{"frames.odom",
                   "map",
                   {"parameter 'frames.odom' cannot be set because it is read-only"}}));

TEST_F(Table, ChangeIsInForceAfterTheOwnerTookIt) {
  EXPECT_EQ(set("margin", "0.25"), "");
  EXPECT_EQ(offered_->margin, 0.25);
  EXPECT_EQ(offered_->margin_max, 0.5);
  EXPECT_EQ(gate_->margin, 0.25);
  EXPECT_EQ(table_.get({"margin"}).at(0).double_value(), 0.25);
}

TEST_F(Table, SetsAllOrNone) {
  EXPECT_NE(set({parameter("margin", value("0.2")), parameter("steps", value("0"))}), "");
  EXPECT_FALSE(offered_);
  EXPECT_EQ(gate_->margin, 0.1);
  EXPECT_EQ(set({parameter("margin", value("0.9")), parameter("margin_max", value("1"))}), "");
  EXPECT_EQ(gate_->margin, 0.9);  // either alone would be refused or change nothing
}

TEST_F(Table, NextChangeDoesNotRememberARefusedOne) {
  EXPECT_NE(set({parameter("steps", value("7")), parameter("margin", value("0.6"))}), "");
  EXPECT_EQ(set("enforce", "false"), "");
  EXPECT_EQ(gate_->steps, 5);
}

TEST_F(Table, TakesBackWhatOneOwnerTookIfAnotherRefuses) {
  auto other = std::make_shared<FrameParams>();
  rt::ParameterTable table;
  std::vector<double> margins;
  table.declare(rt::make_group<TableParams>(gate_, rt::names_of(*gate_),
                                            [&](const auto& p) { margins.push_back(p.margin); }));
  table.declare(rt::make_group<FrameParams>(
      other, rt::names_of(*other), [](const auto&) { throw std::invalid_argument("no"); }));
  const std::vector<Parameter> both{parameter("margin", value("0.3")),
                                    parameter("frames.odom", value("map"))};
  const auto result = table.set(both);
  EXPECT_FALSE(result.successful());
  EXPECT_EQ(result.reason(), "no");
  EXPECT_EQ(margins, (std::vector<double>{0.3, 0.1}));
  EXPECT_EQ(gate_->margin, 0.1);
  EXPECT_EQ(other->odom, "odom");
}

// One value would set both parameters, although their meanings differ.
TEST_F(Table, RefusesANameThatIsDeclaredTwice) {
  rt::ParameterTable table;
  EXPECT_THROW(table.declare(rt::make_fixed_group(std::make_shared<TwoOfOneName>())),
               std::invalid_argument);
  EXPECT_TRUE(table.all().empty());
  EXPECT_THROW(table_.declare(rt::make_fixed_group(std::make_shared<FrameParams>())),
               std::invalid_argument);
}

TEST_F(Table, OnlyTheLivePartMayChange) {
  auto both = std::make_shared<Both>();
  rt::ParameterTable table;
  table.declare(rt::make_group<Both>(both, rt::names_of(both->frames), [](const auto&) {}));
  EXPECT_FALSE(table.set({{parameter("margin", value("0.3"))}}).successful());
  EXPECT_TRUE(table.set({{parameter("frames.odom", value("map"))}}).successful());
  EXPECT_TRUE(table.describe({"margin"}).at(0).read_only());
  EXPECT_FALSE(table.describe({"frames.odom"}).at(0).read_only());
}

// ros2cli parses `[]` as a list of booleans.
TEST_F(Table, TakesAnEmptyListOfWhateverType) {
  for (const auto type :
       {types::PARAMETER_BYTE_ARRAY, types::PARAMETER_BOOL_ARRAY, types::PARAMETER_INTEGER_ARRAY,
        types::PARAMETER_DOUBLE_ARRAY, types::PARAMETER_STRING_ARRAY}) {
    EXPECT_EQ(set("outline", "[1]"), "");
    EXPECT_EQ(set({parameter("outline", empty_list(type))}), "") << int{type};
    EXPECT_TRUE(gate_->outline.empty());
  }
}

TEST_F(Table, RefusesATypeThatDoesNotExist) {
  EXPECT_NE(set({parameter("margin", empty_list(77))}), "");
  EXPECT_NE(set({parameter("outline", empty_list(77))}), "");
}

TEST_F(Table, ListsItsParameters) {
  const Names names{"margin", "steps", "enforce", "mode", "outline", "nobody"};
  const auto values = table_.get(names);
  ASSERT_EQ(values.size(), names.size());
  EXPECT_EQ(values[0].double_value(), 0.1);
  EXPECT_EQ(values[1].integer_value(), 5);
  EXPECT_TRUE(values[2].bool_value());
  EXPECT_EQ(values[3].string_value(), "shared");
  EXPECT_EQ(values[4].double_array_value(), (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(table_.types(names),
            (std::vector<std::uint8_t>{types::PARAMETER_DOUBLE, types::PARAMETER_INTEGER,
                                       types::PARAMETER_BOOL, types::PARAMETER_STRING,
                                       types::PARAMETER_DOUBLE_ARRAY, types::PARAMETER_NOT_SET}));
}

TEST_F(Table, DescribesTypeBoundsChoicesAndMeaning) {
  const auto d = table_.describe({"margin", "steps", "mode", "outline", "frames.odom", "nobody"});
  ASSERT_EQ(d.size(), 6U);
  EXPECT_EQ(d[0].name(), "margin");
  EXPECT_EQ(d[0].type(), types::PARAMETER_DOUBLE);
  EXPECT_EQ(d[0].description(), "[m] gap");
  EXPECT_FALSE(d[0].read_only());
  ASSERT_EQ(d[0].floating_point_range().size(), 1U);
  EXPECT_EQ(d[0].floating_point_range()[0].to_value(), 1.0);
  ASSERT_EQ(d[1].integer_range().size(), 1U);
  EXPECT_EQ(d[1].integer_range()[0].from_value(), 1);
  EXPECT_EQ(d[1].integer_range()[0].to_value(), 50);
  EXPECT_EQ(d[2].additional_constraints(), "one of {manual, shared}");
  EXPECT_EQ(d[3].additional_constraints(), "each in [-5, 5]");
  EXPECT_TRUE(d[4].read_only());
  EXPECT_EQ(d[5].name(), "nobody");
  EXPECT_EQ(d[5].type(), types::PARAMETER_NOT_SET);
}

TEST_F(Table, ListsByPrefixAndDepth) {
  const auto names = [&](const Names& prefixes, std::uint64_t depth) {
    return table_.list(prefixes, depth).names();
  };
  const Names wheels{"wheels.left.radius", "wheels.right.radius"};
  EXPECT_EQ(names({}, 0).size(), 10U);
  EXPECT_EQ(names({}, 1).size(), 7U);  // those without a separator
  EXPECT_EQ(names({}, 2).size(), 8U);
  EXPECT_EQ(names({"wheels"}, 0), wheels);
  EXPECT_EQ(names({"wheels"}, 2), wheels);
  EXPECT_EQ(names({"wheels"}, 1), Names{});
  EXPECT_EQ(names({"wheels.left"}, 1), Names{"wheels.left.radius"});
  EXPECT_EQ(names({"margin"}, 0), Names{"margin"});  // not margin_max
  EXPECT_EQ(names({"wheel", "frames"}, 0), Names{"frames.odom"});
  EXPECT_EQ(table_.list({}, 0).prefixes(), (Names{"frames", "wheels.left", "wheels.right"}));
}

TEST_F(Table, ChangesNothingThatWasMadeReadOnlyLater) {
  table_.make_read_only("margin");
  EXPECT_EQ(set("margin", "0.2"), "parameter 'margin' cannot be set because it is read-only");
  EXPECT_TRUE(table_.describe({"margin"}).at(0).read_only());
  EXPECT_EQ(set("steps", "7"), "");
}

TEST_F(Table, ReportsDeclarationsAndChangesButNotRefusals) {
  Names declared, changed;
  table_.on_event = [&](const auto& new_ones, const auto& changes) {
    for (const auto& p : new_ones) declared.push_back(p.name());
    for (const auto& p : changes) changed.push_back(p.name());
  };
  EXPECT_NE(set("steps", "0"), "");
  EXPECT_EQ(set({parameter("steps", value("6")), parameter("margin", value("0.2"))}), "");
  EXPECT_EQ(changed, (Names{"steps", "margin"}));
  EXPECT_TRUE(declared.empty());
}

TEST_F(Table, RefusesASecondDeclarationOfOneName) {
  EXPECT_THROW(table_.declare(rt::make_fixed_group(std::make_shared<FrameParams>())),
               std::invalid_argument);
}

TEST(ParameterText, StaysOneShortLine) {
  ParameterValue huge;
  huge.type(types::PARAMETER_STRING);
  huge.string_value(std::string(100'000, 'x'));
  EXPECT_LT(rt::to_text(huge).size(), 300U);
}

}  // namespace
}  // namespace tandem
