// SPDX-License-Identifier: Apache-2.0
// In: a params struct with its visit(). Out: its fields as a list, one by one readable, settable
// and checked; what files, command lines and the parameter services have in common.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <msgs.hpp>

#include "tandem/config/params.hpp"

namespace tandem::runtime {

/// One field as visit() declares it. `value` points into the struct.
struct Field {
  using Pointer = std::variant<bool*, int*, double*, std::string*, std::vector<double>*,
                               std::vector<std::string>*>;
  using Limits = std::variant<std::monostate, Range, OneOf>;

  std::string name;
  Pointer value;
  Limits limits;
  std::string meaning;
};

/// Visitor that collects the fields.
struct FieldCollector {
  std::vector<Field>& fields;

  template <class T, class Limits>
  void operator()(const char* name, T& value, const Limits& limits, const char* meaning) const {
    fields.push_back({name, &value, limits, meaning});
  }
  template <class T>
  void operator()(const char* name, T& value, const char* meaning) const {
    fields.push_back({name, &value, {}, meaning});
  }
};

/// The fields of `params`, which must outlive them and stay where it is.
template <class P>
[[nodiscard]] std::vector<Field> fields_of(P& params) {
  std::vector<Field> fields;
  params.visit(FieldCollector{fields});
  return fields;
}

/// Throws std::invalid_argument naming value and bound if the field is outside its declaration.
void check(const Field& field);

/// The field's value as ROS 2 sends it.
[[nodiscard]] rcl_interfaces::msg::ParameterValue value_of(const Field& field);

/// Throws std::invalid_argument if `value` is of another type than the field. An integer will do
/// for a real number (rclcpp refuses that), an empty list for any other; bounds are check()'s.
void assign(const Field& field, const rcl_interfaces::msg::ParameterValue& value);

/// Type, bounds, choices and meaning for those who set it.
[[nodiscard]] rcl_interfaces::msg::ParameterDescriptor descriptor_of(const Field& field,
                                                                     bool read_only);

/// What YAML text means as a parameter: quotes make it text; PARAMETER_NOT_SET for what is none.
[[nodiscard]] rcl_interfaces::msg::ParameterValue value_from_yaml(const std::string& yaml);

/// The value in one line, for people.
[[nodiscard]] std::string to_text(const rcl_interfaces::msg::ParameterValue& value);

}  // namespace tandem::runtime
