// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/yaml_document.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <yaml-cpp/eventhandler.h>

#include "tandem/config/printable.hpp"

namespace tandem {
namespace {

constexpr std::size_t kMaxBytes = 16U << 20U;
constexpr std::size_t kMaxValues = 1'000'000;
constexpr int kMaxDepth = 64;

constexpr const char* kTooDeep =
    "nested deeper than 64 levels; does an anchor contain its own alias?";
constexpr const char* kTooMany = "more than a million values; do aliases refer to other aliases?";
constexpr const char* kTooLong = "larger than 16 MiB";

// Counts events without storing them. yaml-cpp (jbeder/yaml-cpp, up to 0.8) yields endless
// documents where a line starts with a comma or a closing bracket, and YAML::LoadAll would store
// them all.
class EventCounter : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override {
    constexpr int kMaxDocuments = 100;
    if (++documents_ > kMaxDocuments) throw YAML::Exception(mark, "a stray comma or bracket");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    enter(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void count(const YAML::Mark& mark) {
    if (++values_ > kMaxValues) throw YAML::Exception(mark, kTooMany);
  }
  void enter(const YAML::Mark& mark) {
    count(mark);
    if (++depth_ > kMaxDepth) throw YAML::Exception(mark, kTooDeep);
  }

  int documents_ = 0, depth_ = 0;
  std::size_t values_ = 0;
};

void check_events(const std::string& text) {
  std::istringstream stream{text};
  YAML::Parser parser{stream};
  EventCounter counter;
  while (parser.HandleNextDocument(counter)) {
  }
}

// Counts values, once per alias that refers to them.
class ValueCounter {
 public:
  void visit(const YAML::Node& node, int depth = 0) {
    if (depth > kMaxDepth) throw YAML::Exception(node.Mark(), kTooDeep);
    if (++values_ > kMaxValues) throw YAML::Exception(node.Mark(), kTooMany);
    if (node.IsSequence())
      for (const auto& element : node) visit(element, depth + 1);
    if (node.IsMap())
      for (const auto& entry : node) {
        visit(entry.first, depth + 1);
        visit(entry.second, depth + 1);
      }
  }

 private:
  std::size_t values_ = 0;
};

// Also reads files that are not regular, such as pipes. Reads at most one block more than allowed.
std::string read_text(const std::string& file) {
  if (std::filesystem::is_directory(file))
    throw std::invalid_argument(file + " is a folder; give the path of a file in it");
  std::ifstream stream{file, std::ios::binary};
  if (!stream) throw std::invalid_argument(file + ": no such file, or it is not readable");
  std::string text;
  std::array<char, 65536> block;
  while (text.size() <= kMaxBytes) {
    stream.read(block.data(), block.size());
    if (stream.gcount() == 0) break;
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  return text;
}

}  // namespace

YAML::Node parse_document(const std::string& text) {
  if (text.size() > kMaxBytes) throw YAML::Exception(YAML::Mark{}, kTooLong);
  check_events(text);
  const auto documents = YAML::LoadAll(text);
  if (documents.empty()) return {};
  for (std::size_t i = 1; i < documents.size(); ++i)
    if (!documents[i].IsNull())
      throw YAML::Exception(documents[i].Mark(),
                            "a second document begins here and would be ignored; merge the two and "
                            "remove the `---` between them");
  ValueCounter{}.visit(documents.front());
  return documents.front();
}

YAML::Node load_document(const std::string& file) {
  try {
    return parse_document(read_text(file));
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(describe(file, error));
  }
}

std::string describe(const std::string& file, const YAML::Exception& error) {
  return file + ":" + std::to_string(error.mark.line + 1) + ": " + printable(error.msg);
}

std::string yaml_text(const YAML::Node& value) {
  YAML::Emitter out;
  if (value.IsScalar() && value.Tag() == "!") {
    out << YAML::DoubleQuoted << value.Scalar();
    return out.c_str();
  }
  if (!value.IsSequence()) return YAML::Dump(value);
  std::string text;
  for (const auto& element : value) text += (text.empty() ? "" : ", ") + yaml_text(element);
  return "[" + text + "]";
}

}  // namespace tandem
