// SPDX-License-Identifier: Apache-2.0
// Reads the values of a YAML file, with errors that name the file, the line and the key.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tandem {

/// One value of a YAML file: a map that is read key by key, a list, or a scalar. Every function
/// throws std::invalid_argument "FILE:LINE: what is wrong", with keys as `goal.tolerance` or
/// `people[1].speed`.
class YamlReader {
 public:
  static constexpr double kHuge = 1e4;  ///< largest magnitude of coordinates and lengths [m]

  /// The root of a file, or of a text that errors call `name`; see yaml_document.hpp.
  [[nodiscard]] static YamlReader load(const std::string& file);
  /// The root of `text`, which errors call `name`.
  [[nodiscard]] static YamlReader parse(const std::string& text, const std::string& name);

  /// The value of a key of this map. Several equal keys are an error: only one would count.
  [[nodiscard]] YamlReader required(const std::string& key);
  /// The value of a key of this map; nullopt if the map lacks it.
  [[nodiscard]] std::optional<YamlReader> optional(const std::string& key);
  /// The value of a key of this map as T.
  template <class T>
  [[nodiscard]] T required(const std::string& key) {
    return required(key).as<T>();
  }
  /// The value of a key of this map as T; `otherwise` if the map lacks it.
  template <class T>
  [[nodiscard]] T optional(const std::string& key, T otherwise) {
    const auto value = optional(key);
    return value ? value->as<T>() : otherwise;
  }

  /// Fails if the map has a key that has not been asked for.
  void finish();

  /// The entries of this map that have not been asked for, in the file's order; none if it is null.
  [[nodiscard]] std::vector<std::pair<std::string, YamlReader>> rest();

  /// The elements of this list; none if it is null.
  [[nodiscard]] std::vector<YamlReader> elements() const;

  /// This value as bool, int, unsigned, double, std::string, or a vector of double or std::string.
  /// Numbers must be finite.
  template <class T>
  [[nodiscard]] T as() const;

  /// This value as a finite number in [low, high].
  [[nodiscard]] double number(double low, double high) const;
  /// This value as a list of kSize finite numbers, each in [low, high].
  template <int kSize>
  [[nodiscard]] Eigen::Matrix<double, kSize, 1> vector(double low = -kHuge,
                                                       double high = kHuge) const;

  /// A file's path; if it is relative, seen from the folder of the file that is read.
  [[nodiscard]] std::string path() const;

  /// Whether this value is a map.
  [[nodiscard]] bool is_map() const { return node_.IsMap(); }
  /// Whether this value is a list.
  [[nodiscard]] bool is_list() const { return node_.IsSequence(); }
  /// Whether this value is a scalar.
  [[nodiscard]] bool is_scalar() const { return node_.IsScalar(); }
  [[nodiscard]] std::string text() const;   ///< this value as YAML, on one line
  [[nodiscard]] std::string place() const;  ///< "FILE:LINE"
  [[nodiscard]] std::string key() const { return "`" + key_ + "`"; }  ///< "`goal.tolerance`"

  /// Throws std::invalid_argument "FILE:LINE: what".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  YamlReader(const YAML::Node& node, std::string file, std::string key)
      : node_{node}, file_{std::move(file)}, key_{std::move(key)} {}

  void require_map();
  [[nodiscard]] std::string key_of(const std::string& name) const;
  [[nodiscard]] std::string subject() const;
  [[nodiscard]] std::string place_of(const YAML::Node& node) const;
  [[noreturn]] void fail_at(const YAML::Node& node, const std::string& what) const;

  YAML::Node node_;
  std::string file_, key_;  // key_: from the root; empty for the root
  bool is_checked_ = false;
  std::vector<std::string> asked_;
};

template <int kSize>
Eigen::Matrix<double, kSize, 1> YamlReader::vector(double low, double high) const {
  const auto numbers = is_list() ? elements() : std::vector<YamlReader>{};
  if (numbers.size() != kSize) fail(subject() + "expected [" + std::to_string(kSize) + " numbers]");
  Eigen::Matrix<double, kSize, 1> value;
  for (int i = 0; i < kSize; ++i) value[i] = numbers[static_cast<std::size_t>(i)].number(low, high);
  return value;
}

}  // namespace tandem
