// SPDX-License-Identifier: Apache-2.0
// Implements ROS 2's parameter services on declared params structs, without DDS: answers queries
// and applies checked changes.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/parameter_fields.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Type-erased pair of params structs: the one in force, and one in which a change is prepared.
struct ParameterGroup {
  std::vector<Field> in_force;   ///< fields of the struct in force
  std::vector<Field> wanted;     ///< the same fields of the second struct
  std::set<std::string> live{};  ///< fields that may change while the node runs
  std::function<void()> begin;   ///< wanted = in force
  /// Passes `wanted` to the owner, then swaps the two structs, so that a second call undoes the
  /// change. The owner rejects a change by throwing std::invalid_argument without changing
  /// anything.
  std::function<void()> exchange;
};

/// A node's declared parameters. Use on the node's thread only.
class TANDEM_EXPORT ParameterTable {
 public:
  /// Names of parameters.
  using Names = std::vector<std::string>;
  /// Parameters with their values, as messages.
  using Values = std::vector<rcl_interfaces::msg::Parameter>;

  /// Called after a declaration or a change, with the values now in force.
  std::function<void(const Values& declared, const Values& changed)> on_event;

  /// Throws std::invalid_argument for a name that is already declared or occurs twice in the group,
  /// because one given value would set both fields.
  void declare(ParameterGroup group);

  /// Makes a declared parameter read-only from now on.
  void make_read_only(const std::string& name);

  /// Like rclpy, returns PARAMETER_NOT_SET for an undeclared name.
  [[nodiscard]] std::vector<rcl_interfaces::msg::ParameterValue> get(const Names& names) const;
  /// rcl_interfaces/ParameterType of each name; PARAMETER_NOT_SET for an undeclared one.
  [[nodiscard]] std::vector<std::uint8_t> types(const Names& names) const;
  /// Meaning, type and limits of each name; only the name of an undeclared one.
  [[nodiscard]] std::vector<rcl_interfaces::msg::ParameterDescriptor> describe(
      const Names& names) const;
  /// Like rclcpp: the names under any of the prefixes (all names if there are none), at most
  /// `depth` tokens below it (0: unlimited), and the prefixes of these names.
  [[nodiscard]] rcl_interfaces::msg::ListParametersResult list(const Names& prefixes,
                                                               std::uint64_t depth) const;

  /// Sets all of the parameters or none; the result gives the reason for a rejection. Checks each
  /// struct as a whole.
  [[nodiscard]] rcl_interfaces::msg::SetParametersResult set(
      std::span<const rcl_interfaces::msg::Parameter> parameters);

  /// Every parameter with its value.
  [[nodiscard]] Values all() const;

 private:
  struct Place {
    ParameterGroup* group;
    std::size_t index;
  };

  [[nodiscard]] Place find(const std::string& name) const;  // group is null if not found
  void apply(std::span<const rcl_interfaces::msg::Parameter> parameters,
             std::vector<ParameterGroup*>& exchanged);

  std::vector<std::unique_ptr<ParameterGroup>> groups_;
};

/// A group for values of type P. Each change of the `live` fields is passed to `on_change(const
/// P&)`.
template <class P>
[[nodiscard]] ParameterGroup make_group(std::shared_ptr<P> in_force, std::set<std::string> live,
                                        std::function<void(const P&)> on_change) {
  auto wanted = std::make_shared<P>(*in_force);
  return {fields_of(*in_force), fields_of(*wanted), std::move(live),
          [in_force, wanted] { *wanted = *in_force; },
          [in_force, wanted, on_change = std::move(on_change)] {
            on_change(*wanted);
            std::swap(*in_force, *wanted);
          }};
}

/// A group of values that never change while the node runs.
template <class P>
[[nodiscard]] ParameterGroup make_fixed_group(std::shared_ptr<P> in_force) {
  return make_group<P>(std::move(in_force), {}, [](const P&) {});
}

/// The names of a struct's fields.
template <class P>
[[nodiscard]] std::set<std::string> names_of(P& params) {
  std::set<std::string> names;
  for (auto& field : fields_of(params)) names.insert(std::move(field.name));
  return names;
}

}  // namespace tandem::runtime
