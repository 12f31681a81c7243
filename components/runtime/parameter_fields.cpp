// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameter_fields.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include <spdlog/fmt/fmt.h>
#include <yaml-cpp/yaml.h>

#include "tandem/config/yaml_document.hpp"

namespace tandem::runtime {
namespace {

using rcl_interfaces::msg::ParameterDescriptor;
using WireValue = rcl_interfaces::msg::ParameterValue;
namespace types = rcl_interfaces::msg::ParameterType_Constants;

// --- a field's type: what ROS 2 calls it, and how a value of it is read and written
// ----------------

constexpr const char* kind(const bool*) { return "true or false"; }
constexpr const char* kind(const int*) { return "an integer"; }
constexpr const char* kind(const double*) { return "a number"; }
constexpr const char* kind(const std::string*) {
  return "a string (quote a number that is meant as a string)";
}
constexpr const char* kind(const std::vector<double>*) { return "a list of numbers"; }
constexpr const char* kind(const std::vector<std::string>*) { return "a list of strings"; }

WireValue to_value(bool truth) {
  WireValue value;
  value.type(types::PARAMETER_BOOL);
  value.bool_value(truth);
  return value;
}
WireValue to_value(std::int64_t number) {
  WireValue value;
  value.type(types::PARAMETER_INTEGER);
  value.integer_value(number);
  return value;
}
WireValue to_value(int number) { return to_value(std::int64_t{number}); }
WireValue to_value(double number) {
  WireValue value;
  value.type(types::PARAMETER_DOUBLE);
  value.double_value(number);
  return value;
}
WireValue to_value(const std::string& text) {
  WireValue value;
  value.type(types::PARAMETER_STRING);
  value.string_value(text);
  return value;
}
WireValue to_value(const std::vector<double>& numbers) {
  WireValue value;
  value.type(types::PARAMETER_DOUBLE_ARRAY);
  value.double_array_value(numbers);
  return value;
}
WireValue to_value(const std::vector<std::string>& texts) {
  WireValue value;
  value.type(types::PARAMETER_STRING_ARRAY);
  value.string_array_value(texts);
  return value;
}

bool is_empty_list(const WireValue& value) {
  switch (value.type()) {
    case types::PARAMETER_BYTE_ARRAY:
      return value.byte_array_value().empty();
    case types::PARAMETER_BOOL_ARRAY:
      return value.bool_array_value().empty();
    case types::PARAMETER_INTEGER_ARRAY:
      return value.integer_array_value().empty();
    case types::PARAMETER_DOUBLE_ARRAY:
      return value.double_array_value().empty();
    case types::PARAMETER_STRING_ARRAY:
      return value.string_array_value().empty();
    default:
      return false;
  }
}

// False if `value` is not of the field's type.
bool read(const WireValue& value, bool& out) {
  if (value.type() != types::PARAMETER_BOOL) return false;
  out = value.bool_value();
  return true;
}
bool read(const WireValue& value, int& out) {
  if (value.type() != types::PARAMETER_INTEGER) return false;
  if (!std::in_range<int>(value.integer_value())) return false;
  out = static_cast<int>(value.integer_value());
  return true;
}
bool read(const WireValue& value, double& out) {
  if (value.type() == types::PARAMETER_INTEGER) out = static_cast<double>(value.integer_value());
  if (value.type() == types::PARAMETER_DOUBLE) out = value.double_value();
  return value.type() == types::PARAMETER_INTEGER || value.type() == types::PARAMETER_DOUBLE;
}
bool read(const WireValue& value, std::string& out) {
  if (value.type() != types::PARAMETER_STRING) return false;
  out = value.string_value();
  return true;
}
bool read(const WireValue& value, std::vector<double>& out) {
  if (value.type() == types::PARAMETER_DOUBLE_ARRAY) {
    out = value.double_array_value();
    return true;
  }
  const auto& integers = value.integer_array_value();
  if (value.type() != types::PARAMETER_INTEGER_ARRAY && !is_empty_list(value)) return false;
  out.assign(integers.begin(), integers.end());
  if (value.type() != types::PARAMETER_INTEGER_ARRAY) out.clear();
  return true;
}
bool read(const WireValue& value, std::vector<std::string>& out) {
  if (value.type() != types::PARAMETER_STRING_ARRAY && !is_empty_list(value)) return false;
  out = value.string_array_value();
  return true;
}

// --- YAML
// -----------------------------------------------------------------------------------------

template <class T>
std::optional<T> as(const YAML::Node& node) {
  T value{};
  if (!YAML::convert<T>::decode(node, value)) return std::nullopt;
  return value;
}

template <class T>
WireValue tagged(const YAML::Node& node) {
  const auto value = as<T>(node);
  return value ? to_value(*value) : WireValue{};
}

// The tags are those that rcl reads; with another one, such as !!binary, there is no value.
WireValue from_scalar(const YAML::Node& node) {
  const std::string_view tag = node.Tag();
  if (tag == "tag:yaml.org,2002:float") return tagged<double>(node);
  if (tag == "tag:yaml.org,2002:int") return tagged<std::int64_t>(node);
  if (tag == "tag:yaml.org,2002:bool") return tagged<bool>(node);
  if (tag == "!" || tag == "tag:yaml.org,2002:str") return to_value(node.Scalar());  // "!": quoted
  if (tag.starts_with("tag:")) return {};
  if (const auto integer = as<std::int64_t>(node)) return to_value(*integer);
  if (const auto number = as<double>(node)) return to_value(*number);
  if (const auto truth = as<bool>(node)) return to_value(*truth);
  return to_value(node.Scalar());
}

// A list of one type, where integers among real numbers count as real; other lists are rejected.
WireValue from_sequence(const YAML::Node& node) {
  std::vector<WireValue> elements;
  for (const auto& element : node)
    elements.push_back(element.IsScalar() ? from_scalar(element) : WireValue{});
  const auto all = [&](std::uint8_t a, std::uint8_t b) {
    return std::all_of(elements.begin(), elements.end(),
                       [&](const auto& e) { return e.type() == a || e.type() == b; });
  };
  WireValue list;
  if (all(types::PARAMETER_INTEGER, types::PARAMETER_INTEGER)) {
    list.type(types::PARAMETER_INTEGER_ARRAY);
    for (const auto& e : elements) list.integer_array_value().push_back(e.integer_value());
  } else if (all(types::PARAMETER_INTEGER, types::PARAMETER_DOUBLE)) {
    list.type(types::PARAMETER_DOUBLE_ARRAY);
    for (const auto& e : elements) (void)read(e, list.double_array_value().emplace_back());
  } else if (all(types::PARAMETER_BOOL, types::PARAMETER_BOOL)) {
    list.type(types::PARAMETER_BOOL_ARRAY);
    for (const auto& e : elements) list.bool_array_value().push_back(e.bool_value());
  } else if (all(types::PARAMETER_STRING, types::PARAMETER_STRING)) {
    list.type(types::PARAMETER_STRING_ARRAY);
    for (const auto& e : elements) list.string_array_value().push_back(e.string_value());
  }
  return list;
}

// --- text for people
// --------------------------------------------------------------------------------

std::string quoted(const std::string& text) { return '"' + text + '"'; }

// Keeps a message to one line even if the value is very long.
std::string shortened(std::string text) {
  constexpr std::size_t kMax = 200;
  if (text.size() > kMax) text.replace(kMax, std::string::npos, "…");
  return text;
}

std::string long_text(const WireValue& value) {
  switch (value.type()) {
    case types::PARAMETER_BOOL:
      return value.bool_value() ? "true" : "false";
    case types::PARAMETER_INTEGER:
      return fmt::format("{}", value.integer_value());
    case types::PARAMETER_DOUBLE:
      return fmt::format("{}", value.double_value());
    case types::PARAMETER_STRING:
      return quoted(value.string_value());
    case types::PARAMETER_BYTE_ARRAY:
      return fmt::format("[{}]", fmt::join(value.byte_array_value(), ", "));
    case types::PARAMETER_BOOL_ARRAY:
      return fmt::format("[{}]", fmt::join(value.bool_array_value(), ", "));
    case types::PARAMETER_INTEGER_ARRAY:
      return fmt::format("[{}]", fmt::join(value.integer_array_value(), ", "));
    case types::PARAMETER_DOUBLE_ARRAY:
      return fmt::format("[{}]", fmt::join(value.double_array_value(), ", "));
    case types::PARAMETER_STRING_ARRAY: {
      std::vector<std::string> texts;
      for (const auto& text : value.string_array_value()) texts.push_back(quoted(text));
      return fmt::format("[{}]", fmt::join(texts, ", "));
    }
    default:
      return "nothing";
  }
}

// --- descriptors
// ------------------------------------------------------------------------------------

void describe_limits(ParameterDescriptor& out, const double*, const Range& range) {
  rcl_interfaces::msg::FloatingPointRange bounds;
  bounds.from_value(range.min);
  bounds.to_value(range.max);
  out.floating_point_range({bounds});
}
void describe_limits(ParameterDescriptor& out, const int*, const Range& range) {
  rcl_interfaces::msg::IntegerRange bounds;
  bounds.from_value(static_cast<std::int64_t>(range.min));
  bounds.to_value(static_cast<std::int64_t>(range.max));
  bounds.step(1);
  out.integer_range({bounds});
}
void describe_limits(ParameterDescriptor& out, const std::vector<double>*, const Range& range) {
  out.additional_constraints(fmt::format("each in [{}, {}]", range.min, range.max));
}
void describe_limits(ParameterDescriptor& out, const std::vector<std::string>*,
                     const OneOf& choices) {
  out.additional_constraints(fmt::format("each one of {{{}}}", fmt::join(choices.names, ", ")));
}
void describe_limits(ParameterDescriptor& out, const std::string*, const OneOf& choices) {
  out.additional_constraints(fmt::format("one of {{{}}}", fmt::join(choices.names, ", ")));
}

}  // namespace

void check(const Field& field) {
  const char* name = field.name.c_str();
  const char* meaning = field.meaning.c_str();
  std::visit(
      [&](const auto* value, const auto& limits) {
        if constexpr (requires { Checker{}(name, *value, limits, meaning); })
          Checker{}(name, *value, limits, meaning);
      },
      field.value, field.limits);
}

WireValue value_of(const Field& field) {
  return std::visit([](const auto* value) { return to_value(*value); }, field.value);
}

void assign(const Field& field, const WireValue& value) {
  std::visit(
      [&](auto* out) {
        if (!read(value, *out))
          throw std::invalid_argument(field.name + " = " + to_text(value) + " is not " + kind(out));
      },
      field.value);
}

ParameterDescriptor descriptor_of(const Field& field, bool read_only) {
  ParameterDescriptor out;
  out.name(field.name);
  out.type(value_of(field).type());
  out.description(field.meaning);
  out.read_only(read_only);
  std::visit(
      [&](const auto* value, const auto& limits) {
        if constexpr (requires { describe_limits(out, value, limits); })
          describe_limits(out, value, limits);
      },
      field.value, field.limits);
  return out;
}

WireValue value_from_yaml(const std::string& yaml) {
  try {
    const YAML::Node node = parse_document(yaml);
    if (node.IsScalar()) return from_scalar(node);
    if (node.IsSequence()) return from_sequence(node);
  } catch (const YAML::Exception&) {  // invalid YAML is not a parameter value
  }
  return {};
}

const char* type_name(std::uint8_t type) {
  constexpr std::array kNames{"not set",      "bool",        "integer",    "double",
                              "string",       "byte_array",  "bool_array", "integer_array",
                              "double_array", "string_array"};
  return type < kNames.size() ? kNames[type] : "unknown type";
}

std::string to_text(const WireValue& value) { return shortened(long_text(value)); }

}  // namespace tandem::runtime
