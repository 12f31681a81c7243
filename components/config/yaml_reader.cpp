// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/yaml_reader.hpp"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tandem/config/printable.hpp"
#include "tandem/config/yaml_document.hpp"

namespace tandem {

YAML::Node YamlReader::parse(const std::string& text) const {
  try {
    return parse_document(text);
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(describe(name_, error));
  }
}

YAML::Node YamlReader::load() const { return load_document(name_); }

void YamlReader::fail(const YAML::Node& where, const std::string& what) const {
  throw std::invalid_argument(name_ + ":" + std::to_string(where.Mark().line + 1) + ": " +
                              printable(what));
}

void YamlReader::each_once(const YAML::Node& map) const {
  if (!map.IsMap()) fail(map, "expected `key: value` pairs");
  std::map<std::string, int> lines;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail(entry.first, "a key must be a single word");
    const auto& key = entry.first.Scalar();
    const auto [first, is_new] = lines.emplace(key, entry.first.Mark().line + 1);
    if (!is_new)
      fail(entry.first, "`" + key + "` is given twice, first in line " +
                            std::to_string(first->second) + "; merge the two");
  }
}

void YamlReader::allow(const YAML::Node& map, std::initializer_list<const char*> keys) const {
  each_once(map);
  for (const auto& entry : map) {
    const auto& key = entry.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    std::string all;
    for (const char* name : keys) all += (all.empty() ? "" : ", ") + std::string(name);
    fail(entry.first, "unknown key '" + key + "'; valid keys: " + all);
  }
}

YAML::Node YamlReader::required(const YAML::Node& map, const char* key) const {
  if (!map[key]) fail(map, std::string("'") + key + "' is missing");
  return map[key];
}

double YamlReader::number(const YAML::Node& node, double low, double high) const {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value))
    fail(node, "expected a number");
  if (value >= low && value <= high) return value;
  std::ostringstream text;
  text << value << " outside [" << low << ", " << high << "]";
  fail(node, text.str());
}

bool YamlReader::flag(const YAML::Node& map, const char* key, bool otherwise) const {
  if (!map[key]) return otherwise;
  bool value = otherwise;
  if (!YAML::convert<bool>::decode(map[key], value)) fail(map[key], "expected true or false");
  return value;
}

}  // namespace tandem
