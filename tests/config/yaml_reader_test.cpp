// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/yaml_reader.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"

namespace tandem {
namespace {

YamlReader reader(const std::string& text) { return YamlReader::parse(text, "/a/t.yaml"); }

// The error of `read` on a text; empty if there is none.
std::string complaint(const std::string& text, const std::function<void(YamlReader&)>& read) {
  YamlReader root = reader(text);
  try {
    read(root);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(YamlReader, ReadsEachKindOfValue) {
  YamlReader root = reader("{b: true, i: -3, u: 3, d: 0.5, s: word, n: [1, 2.5], w: [x, y]}");
  EXPECT_TRUE(root.required<bool>("b"));
  EXPECT_EQ(root.required<int>("i"), -3);
  EXPECT_EQ(root.required<unsigned>("u"), 3U);
  EXPECT_EQ(root.required<double>("d"), 0.5);
  EXPECT_EQ(root.required<std::string>("s"), "word");
  EXPECT_EQ(root.required<std::vector<double>>("n"), (std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(root.required<std::vector<std::string>>("w"), (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(root.required("n").vector<2>(), Eigen::Vector2d(1.0, 2.5));
  EXPECT_NO_THROW(root.finish());
}

TEST(YamlReader, HasADefaultForAnOptionalKeyThatIsAbsent) {
  YamlReader root = reader("a: 1\n");
  EXPECT_EQ(root.optional("a", 7), 1);
  EXPECT_EQ(root.optional("b", 7), 7);
  EXPECT_FALSE(root.optional("c").has_value());
}

TEST(YamlReader, RefusesAnUnknownKeyWithFileLinePathAndNearestKey) {
  const auto read = [](YamlReader& root) {
    YamlReader goal = root.required("goal");
    (void)goal.optional("pose");
    (void)goal.optional("tolerance", 0.1);
    goal.finish();
  };
  EXPECT_EQ(complaint("goal:\n  pose: 1\n  tolerence: 2\n", read),
            "/a/t.yaml:3: unknown key `goal.tolerence`; valid keys: pose, tolerance; did you mean "
            "`tolerance`?");
  EXPECT_EQ(complaint("goal: {size: 2}\n", read),
            "/a/t.yaml:1: unknown key `goal.size`; valid keys: pose, tolerance");
}

TEST(YamlReader, NamesTheMisspellingOfAMissingKey) {
  const auto read = [](YamlReader& root) { (void)root.required<double>("diameter"); };
  EXPECT_EQ(complaint("diamter: 2\n", read),
            "/a/t.yaml:1: `diameter` is missing; is `diamter` a misspelling of it?");
  EXPECT_EQ(complaint("height: 2\n", read), "/a/t.yaml:1: `diameter` is missing");
}

TEST(YamlReader, RefusesAKeyThatIsGivenTwiceAndAKeyThatIsNoWord) {
  const auto read = [](YamlReader& root) { (void)root.optional("a"); };
  EXPECT_EQ(complaint("a: 1\nb: 2\nb: 3\n", read),
            "/a/t.yaml:3: `b` is given twice, first in line 2; bring both together");
  EXPECT_EQ(complaint("? [a]\n: 1\n", read), "/a/t.yaml:1: a key must be a word");
  EXPECT_EQ(complaint("- 1\n", read), "/a/t.yaml:1: expected `key: value` lines");
}

TEST(YamlReader, NamesAnElementByItsPlaceInTheList) {
  const auto read = [](YamlReader& root) {
    for (YamlReader& each : root.required("people").elements()) (void)each.required<double>("way");
  };
  EXPECT_EQ(complaint("people:\n  - {way: 1}\n  - {way: x}\n", read),
            "/a/t.yaml:3: `people[1].way` = x is not a finite number");
  EXPECT_EQ(complaint("people: 3\n", read), "/a/t.yaml:1: `people`: expected a list");
  EXPECT_EQ(complaint("people:\n", read), "");
}

TEST(YamlReader, RefusesValuesOfAnotherKind) {
  const auto is_no = [](const std::string& value, const auto& read) {
    return complaint("a: " + value + "\n", [&](YamlReader& root) { read(root.required("a")); });
  };
  const auto number = [](const YamlReader& value) { (void)value.as<double>(); };
  const auto count = [](const YamlReader& value) { (void)value.as<unsigned>(); };
  const auto share = [](const YamlReader& value) { (void)value.number(0.0, 1.0); };
  const auto point = [](const YamlReader& value) { (void)value.vector<2>(); };
  EXPECT_EQ(is_no(".nan", number), "/a/t.yaml:1: `a` = .nan is not a finite number");
  EXPECT_EQ(is_no("-1", count), "/a/t.yaml:1: `a` = -1 is not an integer of 0 or more");
  EXPECT_EQ(is_no("2", share), "/a/t.yaml:1: `a` = 2 outside [0, 1]");
  EXPECT_EQ(is_no(".nan", share), "/a/t.yaml:1: `a` = nan outside [0, 1]");
  EXPECT_EQ(is_no("x", share), "/a/t.yaml:1: `a`: expected a number");
  EXPECT_EQ(is_no("[1, 2, 3]", point), "/a/t.yaml:1: `a`: expected [2 numbers]");
  EXPECT_EQ(is_no("[1, x]", point), "/a/t.yaml:1: `a[1]`: expected a number");
}

TEST(YamlReader, ListsTheRestOfAMapInTheFilesOrder) {
  YamlReader root = reader("z: 1\nname: n\na: [1, \"2\"]\n");
  (void)root.required("name");
  const auto rest = root.rest();
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest[0].first, "z");
  EXPECT_EQ(rest[1].first, "a");
  EXPECT_EQ(rest[1].second.text(), "[1, \"2\"]");
  EXPECT_EQ(rest[1].second.place(), "/a/t.yaml:3");
  EXPECT_TRUE(reader("").rest().empty());
}

TEST(YamlReader, SeesRelativePathsFromTheFilesFolder) {
  YamlReader root = reader("a: ../b/c.bt\nd: /e/f.bt\n");
  EXPECT_EQ(root.required("a").path(), "/b/c.bt");
  EXPECT_EQ(root.required("d").path(), "/e/f.bt");
}

TEST(YamlReader, PrintsOneLineWhateverTheFileContains) {
  const auto read = [](YamlReader& root) { root.finish(); };
  EXPECT_EQ(complaint("\"a\\nb\": 1\n", read).find('\n'), std::string::npos);
}

}  // namespace
}  // namespace tandem
