// SPDX-License-Identifier: Apache-2.0
// Reads values from the nodes of one YAML file, with errors that name the file and the line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <initializer_list>
#include <string>

namespace tandem {

/// Reads values from one file. Every function throws std::invalid_argument naming the file, the
/// line and the error.
class YamlReader {
 public:
  static constexpr double kHuge = 1e4;  ///< largest magnitude of coordinates and lengths [m]

  explicit YamlReader(std::string name) : name_{std::move(name)} {}

  /// The root of `text`, or of the file given by the reader's name; see yaml_document.hpp.
  [[nodiscard]] YAML::Node parse(const std::string& text) const;
  [[nodiscard]] YAML::Node load() const;

  [[noreturn]] void fail(const YAML::Node& where, const std::string& what) const;

  /// Rejects a node that is not a map, and duplicate keys: the reader would see only the first.
  void each_once(const YAML::Node& map) const;

  /// As each_once; also rejects keys not in `keys`.
  void allow(const YAML::Node& map, std::initializer_list<const char*> keys) const;

  [[nodiscard]] YAML::Node required(const YAML::Node& map, const char* key) const;
  [[nodiscard]] double number(const YAML::Node& node, double low, double high) const;
  [[nodiscard]] bool flag(const YAML::Node& map, const char* key, bool otherwise) const;

  template <int kSize>
  [[nodiscard]] Eigen::Matrix<double, kSize, 1> vector(const YAML::Node& node, double low = -kHuge,
                                                       double high = kHuge) const {
    if (!node.IsSequence() || node.size() != kSize)
      fail(node, "expected [" + std::to_string(kSize) + " numbers]");
    Eigen::Matrix<double, kSize, 1> value;
    for (int i = 0; i < kSize; ++i) value[i] = number(node[i], low, high);
    return value;
  }

 private:
  std::string name_;
};

}  // namespace tandem
