// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/parameter_table.hpp"

#include <algorithm>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace tandem::runtime {
namespace {

using rcl_interfaces::msg::Parameter;
using WireValue = rcl_interfaces::msg::ParameterValue;
using rcl_interfaces::msg::SetParametersResult;
namespace types = rcl_interfaces::msg::ParameterType_Constants;

constexpr char kSeparator = '.';

Parameter to_parameter(const Field& field) {
  Parameter parameter;
  parameter.name(field.name);
  parameter.value(value_of(field));
  return parameter;
}

bool within(std::string_view name, std::uint64_t depth) {
  const auto separators = std::count(name.begin(), name.end(), kSeparator);
  return depth == 0 || static_cast<std::uint64_t>(separators) < depth;
}

bool is_under(std::string_view name, std::string_view prefix, std::uint64_t depth) {
  if (!name.starts_with(prefix)) return false;
  if (name.size() == prefix.size()) return true;
  return name[prefix.size()] == kSeparator && within(name.substr(prefix.size() + 1), depth);
}

// The refusals below say first what rclcpp says.
std::string wrong_type(const Field& field, const WireValue& value) {
  return fmt::format(
      "Wrong parameter type, parameter {{{}}} is of type {{{}}}, setting it to {{{}}} is not "
      "allowed.",
      field.name, type_name(value_of(field).type()), type_name(value.type()));
}

void set_value(const Field& field, const WireValue& value) {
  if (value.type() == types::PARAMETER_NOT_SET)
    throw std::invalid_argument("cannot undeclare a statically typed parameter");
  try {
    assign(field, value);
  } catch (const std::invalid_argument&) {
    if (value.type() == value_of(field).type()) throw;  // an integer that is too large
    throw std::invalid_argument(wrong_type(field, value));
  }
}

void check_value(const Field& field) {
  try {
    check(field);
  } catch (const std::invalid_argument& error) {
    const bool integer = std::holds_alternative<int*>(field.value);
    if (!integer && !std::holds_alternative<double*>(field.value)) throw;
    throw std::invalid_argument(fmt::format("Parameter {{{}}} doesn't comply with {} range. {}",
                                            field.name, integer ? "integer" : "floating point",
                                            error.what()));
  }
}

bool is_listed(const std::string& name, const ParameterTable::Names& prefixes,
               std::uint64_t depth) {
  if (prefixes.empty()) return within(name, depth);
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const auto& prefix) { return is_under(name, prefix, depth); });
}

}  // namespace

void ParameterTable::declare(ParameterGroup group) {
  Values declared;
  std::set<std::string_view> names;
  for (const Field& field : group.in_force) {
    if (!names.insert(field.name).second || find(field.name).group != nullptr)
      throw std::invalid_argument("parameter " + field.name + " is declared twice");
    declared.push_back(to_parameter(field));
  }
  groups_.push_back(std::make_unique<ParameterGroup>(std::move(group)));
  if (on_event) on_event(declared, {});
}

ParameterTable::Place ParameterTable::find(const std::string& name) const {
  for (const auto& group : groups_)
    for (std::size_t i = 0; i < group->in_force.size(); ++i)
      if (group->in_force[i].name == name) return {group.get(), i};
  return {nullptr, 0};
}

void ParameterTable::make_read_only(const std::string& name) {
  if (const auto [group, index] = find(name); group != nullptr) group->live.erase(name);
}

std::vector<WireValue> ParameterTable::get(const Names& names) const {
  std::vector<WireValue> values(names.size());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto [group, index] = find(names[i]); group != nullptr)
      values[i] = value_of(group->in_force[index]);
  return values;
}

std::vector<std::uint8_t> ParameterTable::types(const Names& names) const {
  std::vector<std::uint8_t> types;
  for (const auto& value : get(names)) types.push_back(value.type());
  return types;
}

std::vector<rcl_interfaces::msg::ParameterDescriptor> ParameterTable::describe(
    const Names& names) const {
  std::vector<rcl_interfaces::msg::ParameterDescriptor> descriptors;
  for (const auto& name : names) {
    descriptors.emplace_back().name(name);
    if (const auto [group, index] = find(name); group != nullptr)
      descriptors.back() = descriptor_of(group->in_force[index], !group->live.contains(name));
  }
  return descriptors;
}

rcl_interfaces::msg::ListParametersResult ParameterTable::list(const Names& prefixes,
                                                               std::uint64_t depth) const {
  rcl_interfaces::msg::ListParametersResult result;
  std::set<std::string> found;
  for (const auto& group : groups_) {
    for (const Field& field : group->in_force) {
      if (!is_listed(field.name, prefixes, depth)) continue;
      result.names().push_back(field.name);
      const auto last = field.name.rfind(kSeparator);
      if (last != std::string::npos) found.insert(field.name.substr(0, last));
    }
  }
  result.prefixes().assign(found.begin(), found.end());
  return result;
}

ParameterTable::Values ParameterTable::all() const {
  Values values;
  for (const auto& group : groups_)
    for (const Field& field : group->in_force) values.push_back(to_parameter(field));
  return values;
}

SetParametersResult ParameterTable::set(std::span<const Parameter> parameters) {
  SetParametersResult result;
  std::vector<ParameterGroup*> exchanged;
  try {
    apply(parameters, exchanged);
  } catch (const std::invalid_argument& error) {
    for (ParameterGroup* group : exchanged) group->exchange();
    result.successful(false);
    result.reason(error.what());
    return result;
  }
  result.successful(true);
  Values changed;
  for (const Parameter& parameter : parameters) {
    const auto [group, index] = find(parameter.name());
    changed.push_back(to_parameter(group->in_force[index]));
  }
  if (on_event && !changed.empty()) on_event({}, changed);
  return result;
}

void ParameterTable::apply(std::span<const Parameter> parameters,
                           std::vector<ParameterGroup*>& exchanged) {
  std::vector<ParameterGroup*> touched;
  for (const Parameter& parameter : parameters) {
    const auto [group, index] = find(parameter.name());
    const std::string refusal = "parameter '" + parameter.name() + "' cannot be set because it ";
    if (group == nullptr) throw std::invalid_argument(refusal + "was not declared");
    if (!group->live.contains(parameter.name()))
      throw std::invalid_argument(refusal + "is read-only");
    if (std::find(touched.begin(), touched.end(), group) == touched.end()) {
      group->begin();
      touched.push_back(group);
    }
    set_value(group->wanted[index], parameter.value());
  }
  for (const ParameterGroup* group : touched)
    for (const Field& field : group->wanted) check_value(field);
  for (ParameterGroup* group : touched) {
    group->exchange();
    exchanged.push_back(group);
  }
}

}  // namespace tandem::runtime
