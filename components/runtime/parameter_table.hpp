// SPDX-License-Identifier: Apache-2.0
// In: declared params structs, and what ROS 2 asks about them. Out: its answers, and changes that
// were checked. No DDS.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/parameter_fields.hpp"

namespace tandem::runtime {

/// A params struct in force and a second one in which a change is made up, whatever their type.
struct ParameterGroup {
  std::vector<Field> in_force;
  std::vector<Field> wanted;     ///< the same fields of the second struct
  std::set<std::string> live{};  ///< what may change while the node runs
  std::function<void()> begin;   ///< wanted = in force
  /// Offers what is wanted to the owner, who may throw std::invalid_argument and then has changed
  /// nothing; else exchanges the two, so that a second call takes the change back.
  std::function<void()> exchange;
};

/// A node's declared parameters. Belongs to the node's thread.
class ParameterTable {
 public:
  using Names = std::vector<std::string>;
  using Values = std::vector<rcl_interfaces::msg::Parameter>;

  /// Called after a declaration or a change, with the values now in force.
  std::function<void(const Values& declared, const Values& changed)> on_event;

  /// Throws std::invalid_argument for a name that is declared already, or twice in the group: one
  /// given value would fill both.
  void declare(ParameterGroup group);

  /// As rclpy: PARAMETER_NOT_SET for a name that nobody declared.
  [[nodiscard]] std::vector<rcl_interfaces::msg::ParameterValue> get(const Names& names) const;
  [[nodiscard]] std::vector<std::uint8_t> types(const Names& names) const;
  [[nodiscard]] std::vector<rcl_interfaces::msg::ParameterDescriptor> describe(
      const Names& names) const;
  /// As rclcpp: names under any of the prefixes (none: all), at most `depth` tokens below it
  /// (0: all), and the prefixes that they have.
  [[nodiscard]] rcl_interfaces::msg::ListParametersResult list(const Names& prefixes,
                                                               std::uint64_t depth) const;

  /// All of them or none; the reason if none. Checks the structs as a whole.
  [[nodiscard]] rcl_interfaces::msg::SetParametersResult set(
      std::span<const rcl_interfaces::msg::Parameter> parameters);

  /// Every parameter with its value.
  [[nodiscard]] Values all() const;

 private:
  struct Place {
    ParameterGroup* group;
    std::size_t index;
  };

  [[nodiscard]] Place find(const std::string& name) const;  // group null: nowhere
  void apply(std::span<const rcl_interfaces::msg::Parameter> parameters,
             std::vector<ParameterGroup*>& exchanged);

  std::vector<std::unique_ptr<ParameterGroup>> groups_;
};

/// Values of type P as a group. `on_change(const P&)` is offered each change of the fields `live`.
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

/// Values that never change while the node runs.
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
