// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/yaml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "tandem/config/nearest_name.hpp"
#include "tandem/config/printable.hpp"
#include "tandem/config/yaml_document.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr const char* kind(bool) { return "true or false"; }
constexpr const char* kind(double) { return "a finite number"; }
constexpr const char* kind(int) { return "an integer"; }
constexpr const char* kind(unsigned) { return "an integer of 0 or more"; }
const char* kind(const std::string&) { return "text"; }
const char* kind(const std::vector<double>&) { return "a list of finite numbers"; }
const char* kind(const std::vector<std::string>&) { return "a list of words"; }

template <class T>
bool is_finite(const T&) {
  return true;
}
bool is_finite(double value) { return std::isfinite(value); }
bool is_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

YamlReader YamlReader::load(const std::string& file) { return {load_document(file), file, ""}; }

YamlReader YamlReader::parse(const std::string& text, const std::string& name) {
  try {
    return {parse_document(text), name, ""};
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(describe(name, error));
  }
}

std::optional<YamlReader> YamlReader::optional(const std::string& key) {
  require_map();
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.push_back(key);
  const YAML::Node value = std::as_const(node_)[key];
  if (!value) return std::nullopt;
  return YamlReader{value, file_, key_of(key)};
}

YamlReader YamlReader::required(const std::string& key) {
  if (const auto value = optional(key)) return *value;
  std::vector<std::string> others;
  for (const auto& [other, value] : rest()) others.push_back(other);
  const std::string meant = nearest_name(key, others);
  fail("`" + key_of(key) + "` is missing" +
       (meant.empty() ? "" : "; is `" + meant + "` a misspelling of it?"));
}

void YamlReader::finish() {
  require_map();
  for (const auto& entry : node_) {
    const auto& name = entry.first.Scalar();
    if (std::find(asked_.begin(), asked_.end(), name) != asked_.end()) continue;
    fail_at(entry.first, "unknown key `" + key_of(name) + "`; valid keys: " + joined(asked_) +
                             did_you_mean(name, asked_));
  }
}

std::vector<std::pair<std::string, YamlReader>> YamlReader::rest() {
  if (node_.IsNull()) return {};
  require_map();
  std::vector<std::pair<std::string, YamlReader>> entries;
  for (const auto& entry : node_) {
    const auto& name = entry.first.Scalar();
    if (std::find(asked_.begin(), asked_.end(), name) == asked_.end())
      entries.emplace_back(name, YamlReader{entry.second, file_, key_of(name)});
  }
  return entries;
}

std::vector<YamlReader> YamlReader::elements() const {
  if (node_.IsNull()) return {};
  if (!node_.IsSequence()) fail(subject() + "expected a list");
  std::vector<YamlReader> all;
  for (const auto& element : node_)
    all.push_back({element, file_, key_ + "[" + std::to_string(all.size()) + "]"});
  return all;
}

template <class T>
T YamlReader::as() const {
  try {
    const T value = node_.as<T>();
    if (is_finite(value)) return value;
  } catch (const YAML::Exception&) {  // reported below
  }
  fail(key() + " = " + text() + " is not " + kind(T{}));
}

template bool YamlReader::as<bool>() const;
template int YamlReader::as<int>() const;
template unsigned YamlReader::as<unsigned>() const;
template double YamlReader::as<double>() const;
template std::string YamlReader::as<std::string>() const;
template std::vector<double> YamlReader::as<std::vector<double>>() const;
template std::vector<std::string> YamlReader::as<std::vector<std::string>>() const;

double YamlReader::number(double low, double high) const {
  double value = 0.0;
  if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value))
    fail(subject() + "expected a number");
  if (value >= low && value <= high) return value;
  std::ostringstream text;
  text << key() << " = " << value << " outside [" << low << ", " << high << "]";
  fail(text.str());
}

std::string YamlReader::path() const {
  const fs::path given{as<std::string>()};
  if (given.is_absolute()) return given.string();
  return (fs::path{file_}.parent_path() / given).lexically_normal().string();
}

std::string YamlReader::text() const { return yaml_text(node_); }

std::string YamlReader::place() const { return place_of(node_); }

void YamlReader::fail(const std::string& what) const { fail_at(node_, what); }

// Refuses what is no map, and equal keys.
void YamlReader::require_map() {
  if (std::exchange(is_checked_, true)) return;
  if (!node_.IsMap()) fail(subject() + "expected `key: value` lines");
  std::map<std::string, int> lines;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) fail_at(entry.first, "a key must be a word");
    const auto& name = entry.first.Scalar();
    const auto [first, is_new] = lines.emplace(name, entry.first.Mark().line + 1);
    if (!is_new)
      fail_at(entry.first, "`" + key_of(name) + "` is given twice, first in line " +
                               std::to_string(first->second) + "; bring both together");
  }
}

std::string YamlReader::key_of(const std::string& name) const {
  return key_.empty() ? name : key_ + "." + name;
}

std::string YamlReader::subject() const { return key_.empty() ? "" : key() + ": "; }

// An empty file has no line.
std::string YamlReader::place_of(const YAML::Node& node) const {
  return node.Mark().is_null() ? file_ : file_ + ":" + std::to_string(node.Mark().line + 1);
}

void YamlReader::fail_at(const YAML::Node& node, const std::string& what) const {
  throw std::invalid_argument(place_of(node) + ": " + printable(what));
}

}  // namespace tandem
