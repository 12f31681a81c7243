// SPDX-License-Identifier: Apache-2.0
// Fills params structs from ROS 2 parameter files, system file values and `-p k:=v`, and checks
// them.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tandem/runtime/parameter_fields.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// One value as YAML text, and where it was written ("robot.yaml:12", "command line").
struct ParameterValue {
  std::string yaml;      ///< the value as text
  std::string origin;    ///< for messages
  bool for_all = false;  ///< given for every node (`/**`, plain `-p`); nodes may lack the key
};

/// Sources of a node's parameters. Later ones win: files in order, values, overrides.
struct ParameterSources {
  std::vector<std::string> files{};                ///< ROS 2 form: `node: ros__parameters:`, `/**:`
  std::map<std::string, ParameterValue> values{};  ///< from the system file, by name
  std::vector<std::string> override_files{};       ///< --params-file
  std::map<std::string, ParameterValue> overrides{};  ///< -p k:=v
};

/// A node's given parameters, before any struct has declared them.
class TANDEM_EXPORT ParameterStore {
 public:
  /// Throws std::runtime_error naming file and line if a file is missing or not of ROS 2's form.
  ParameterStore(std::string fully_qualified_name, const ParameterSources& sources);
  ~ParameterStore();
  ParameterStore(ParameterStore&&) noexcept;
  ParameterStore& operator=(ParameterStore&&) noexcept;

  /// Loads the field if a value is given, and checks it. Throws std::invalid_argument with one
  /// line: origin, key, value, bound.
  void load(const Field& field);

  /// Visitor of a params struct: loads each field.
  template <class T, class Limits>
  void operator()(const char* name, T& value, const Limits& limits, const char* meaning) {
    load({name, &value, limits, meaning});
  }
  template <class T>
  void operator()(const char* name, T& value, const char* meaning) {
    load({name, &value, {}, meaning});
  }

  /// Whether any key with that prefix is given.
  [[nodiscard]] bool gives_any(const std::string& prefix) const;

  /// Counts every key with that prefix as declared.
  void accept_all(const std::string& prefix);

  /// Throws std::invalid_argument for the first key for this node that no struct declared, with the
  /// declared name that is nearest to it. Keys of
  /// `/**` sections are exempt, except retired names: ignoring one would silently replace the
  /// file's value by a default.
  void check_unknown() const;

 private:
  void check_retired() const;

  struct State;
  std::unique_ptr<State> state_;
};

/// Keys of `/**` sections that no node of this process has declared so far: "file:line: key".
[[nodiscard]] TANDEM_EXPORT std::vector<std::string> unused_wildcard_keys();

/// A params struct whose values may be replaced between callbacks. Behaves as a `const P*`.
template <class P>
class Parameters {
 public:
  Parameters() : values_{std::make_shared<P>()} {}
  explicit Parameters(std::shared_ptr<const P> values) : values_{std::move(values)} {}

  /// The values in force. Do not keep the reference beyond the callback.
  const P& operator*() const { return *values_; }
  /// A value in force.
  const P* operator->() const { return values_.get(); }
  /// The values in force, never null.
  [[nodiscard]] const P* get() const { return values_.get(); }

 private:
  std::shared_ptr<const P> values_;
};

}  // namespace tandem::runtime
