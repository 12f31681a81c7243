// SPDX-License-Identifier: Apache-2.0
// Lists the fields of a params struct and reads, sets and checks them one by one. Shared by
// parameter files, the command line and the parameter services.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <msgs.hpp>

#include "tandem/config/params.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// One field as visit() declares it. `value` points into the struct.
struct Field {
  /// Where the value is.
  using Pointer = std::variant<bool*, int*, double*, std::string*, std::vector<double>*,
                               std::vector<std::string>*>;
  /// What it may be; monostate: anything.
  using Limits = std::variant<std::monostate, Range, OneOf>;

  std::string name;     ///< as in YAML
  Pointer value;        ///< into the struct
  Limits limits;        ///< bounds or choices
  std::string meaning;  ///< unit and meaning
};

/// Visitor that collects a struct's fields.
struct FieldCollector {
  std::vector<Field>& fields;  ///< where they are put

  /// Takes a field with limits.
  template <class T, class Limits>
  void operator()(const char* name, T& value, const Limits& limits, const char* meaning) const {
    fields.push_back({name, &value, limits, meaning});
  }
  /// Takes a field without limits.
  template <class T>
  void operator()(const char* name, T& value, const char* meaning) const {
    fields.push_back({name, &value, {}, meaning});
  }
};

/// The fields of `params`, which must outlive them and must not move.
template <class P>
[[nodiscard]] std::vector<Field> fields_of(P& params) {
  std::vector<Field> fields;
  params.visit(FieldCollector{fields});
  return fields;
}

/// Throws std::invalid_argument naming value and bound if the field is outside its declared limits.
TANDEM_EXPORT void check(const Field& field);

/// The field's value as a ROS 2 message.
[[nodiscard]] TANDEM_EXPORT rcl_interfaces::msg::ParameterValue value_of(const Field& field);

/// Throws std::invalid_argument if `value` has a different type than the field. Accepts an integer
/// for a real number (unlike rclcpp) and an empty list for any list. Does not check limits; check()
/// does.
TANDEM_EXPORT void assign(const Field& field, const rcl_interfaces::msg::ParameterValue& value);

/// Type, bounds, choices and meaning of the field.
[[nodiscard]] TANDEM_EXPORT rcl_interfaces::msg::ParameterDescriptor descriptor_of(
    const Field& field, bool read_only);

/// Parses YAML text as a parameter value; quoted values are strings. PARAMETER_NOT_SET if invalid.
[[nodiscard]] TANDEM_EXPORT rcl_interfaces::msg::ParameterValue value_from_yaml(
    const std::string& yaml);

/// ROS 2's name of a rcl_interfaces/ParameterType, as "double_array".
[[nodiscard]] TANDEM_EXPORT const char* type_name(std::uint8_t type);

/// The value as one line of readable text.
[[nodiscard]] TANDEM_EXPORT std::string to_text(const rcl_interfaces::msg::ParameterValue& value);

}  // namespace tandem::runtime
