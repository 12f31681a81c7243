// SPDX-License-Identifier: Apache-2.0
// Defines a parameter struct: plain members and one `visit` that names each of them with its range
// and meaning. YAML files, command lines and `tandem describe` all use that one declaration.
#pragma once

#include <cmath>
#include <initializer_list>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// Closed interval a numeric parameter must lie in.
struct Range {
  double min, max;  ///< both ends belong to the interval
};

/// The values a text parameter may take.
struct OneOf {
  std::vector<std::string> names;  ///< all of them
};

/// A parameter name that had several meanings in one node, and the names that replace it.
struct RetiredName {
  std::string_view name;  ///< the name as it was
  const char* instead;    ///< what to use for which purpose
};
/// All retired names. Using one is an error that prints its replacement.
inline constexpr RetiredName kRetiredNames[]{
    {"command_timeout",
     "base_timeout: the base itself stops after this long without a command; arbitrated_timeout: "
     "safety_filter stops after this long without cmd_vel_arbitrated; in_force_timeout: "
     "local_planner treats a cmd_vel older than this as zero"}};

/// The replacement for a retired name; null if the name is not retired.
[[nodiscard]] constexpr const char* instead_of(std::string_view name) {
  for (const RetiredName& retired : kRetiredNames)
    if (retired.name == name) return retired.instead;
  return nullptr;
}

/// Visitor that throws std::invalid_argument for the first field outside its declaration. Every
/// visitor of parameters has these six overloads of operator().
struct Checker {
  /// Accepts a value inside its range or among its choices; NaN is outside of every range.
  void operator()(const char* name, double value, const Range& range, const char* meaning) const {
    if (value >= range.min && value <= range.max) return;  // false for NaN
    std::ostringstream text;
    text << name << " = " << value << " outside [" << range.min << ", " << range.max
         << "]: " << meaning;
    throw std::invalid_argument(text.str());
  }
  void operator()(const char* name, int value, const Range& range, const char* meaning) const {
    (*this)(name, static_cast<double>(value), range, meaning);
  }
  /// A text must be one of the choices.
  void operator()(const char* name, const std::string& value, const OneOf& choices,
                  const char* meaning) const {
    std::string all;
    for (const auto& choice : choices.names) {
      if (choice == value) return;
      all += (all.empty() ? "" : ", ") + choice;
    }
    throw std::invalid_argument(std::string(name) + " = '" + value + "' is not one of {" + all +
                                "}: " + meaning);
  }
  void operator()(const char* name, const std::vector<double>& values, const Range& range,
                  const char* meaning) const {
    for (const double value : values) (*this)(name, value, range, meaning);
  }
  void operator()(const char* name, const std::vector<std::string>& values, const OneOf& choices,
                  const char* meaning) const {
    for (const std::string& value : values) (*this)(name, value, choices, meaning);
  }
  void operator()(const char*, bool, const char*) const {}
  void operator()(const char*, const std::string&, const char*) const {}
};

/// Throws std::invalid_argument naming the first field outside its Range or OneOf.
template <class Params>
void check(Params params) {
  params.visit(Checker{});
}

}  // namespace tandem
