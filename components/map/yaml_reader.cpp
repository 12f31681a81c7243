// SPDX-License-Identifier: Apache-2.0
#include "map/yaml_reader.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include <yaml-cpp/eventhandler.h>

#include "yaml_document.hpp"

namespace tandem {
namespace {

// What a file holds must not break the one line that an error is.
std::string one_line(std::string text) {
  const auto breaks = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  std::replace_if(text.begin(), text.end(), breaks, '?');
  return text;
}

// Counts documents and keeps nothing of them.
struct DocumentCounter : YAML::EventHandler {
  int documents = 0;
  YAML::Mark start;

  void OnDocumentStart(const YAML::Mark& mark) override {
    ++documents;
    start = mark;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// yaml-cpp finds documents without end where a line begins with a comma or a closing bracket, and
// YAML::LoadAll would keep them all.
void refuse_endless(const std::string& text) {
  constexpr int kMostDocuments = 100;
  std::istringstream stream{text};
  YAML::Parser parser{stream};
  DocumentCounter counter;
  while (parser.HandleNextDocument(counter))
    if (counter.documents > kMostDocuments)
      throw YAML::Exception(counter.start, "a comma or bracket that belongs to nothing");
}

}  // namespace

YAML::Node YamlReader::parse(const std::string& text) const {
  try {
    refuse_endless(text);
    return one_document(YAML::LoadAll(text));
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(name_ + ":" + std::to_string(error.mark.line + 1) + ": " +
                             one_line(error.msg));
  }
}

YAML::Node YamlReader::load() const {
  std::ifstream stream{name_};
  std::stringstream text;
  if (!std::filesystem::is_regular_file(name_) || !(text << stream.rdbuf()))
    throw std::runtime_error(name_ + ": no such file, or it is empty or cannot be read");
  return parse(text.str());
}

void YamlReader::fail(const YAML::Node& where, const std::string& what) const {
  throw std::runtime_error(name_ + ":" + std::to_string(where.Mark().line + 1) + ": " +
                           one_line(what));
}

void YamlReader::each_once(const YAML::Node& map) const {
  if (!map.IsMap()) fail(map, "expected `key: value` pairs");
  std::map<std::string, int> lines;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail(entry.first, "a key must be a word");
    const auto& key = entry.first.Scalar();
    const auto [first, is_new] = lines.emplace(key, entry.first.Mark().line + 1);
    if (!is_new)
      fail(entry.first, "`" + key + "` is given twice, first in line " +
                            std::to_string(first->second) + "; bring both together");
  }
}

void YamlReader::allow(const YAML::Node& map, std::initializer_list<const char*> keys) const {
  each_once(map);
  for (const auto& entry : map) {
    const auto& key = entry.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    std::string all;
    for (const char* name : keys) all += (all.empty() ? "" : ", ") + std::string(name);
    fail(entry.first, "unknown key '" + key + "'; known here: " + all);
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
