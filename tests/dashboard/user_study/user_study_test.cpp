// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/user_study/user_study.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "dashboard/damaged.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTest =
    R"({"person":3,"trials":[{"method":"shared","task":2,"practice":false,"allowed":120,"time":18.25,
        "reached":true,"collisions":0,"min_clearance":0.125,"path_length":11.5}]})";
constexpr const char* kHeading =
    "person,method,task,practice,allowed,time,reached,collisions,min_clearance,path_length\n";
constexpr const char* kRow = "3,shared,2,0,120.0,18.25,1,0,0.125,11.5\n";

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream{path}.rdbuf();
  return text.str();
}

TEST(UserStudy, IsOneRowForEachTrial) {
  const auto test = parse_user_study(kTest);
  EXPECT_EQ(to_csv(test, true), std::string{kHeading} + kRow);
  EXPECT_EQ(to_csv(test, false), kRow);
}

TEST(UserStudy, IsSavedBesideEarlierOnes) {
  char name[] = "/tmp/tandem_user_test_XXXXXX";
  const fs::path folder = fs::path{mkdtemp(name)} / "new";
  const auto test = parse_user_study(kTest);
  EXPECT_EQ(save(test, folder), folder / "user_test_1.json");
  EXPECT_EQ(save(test, folder), folder / "user_test_2.json");
  EXPECT_EQ(text_of(folder / "user_tests.csv"), std::string{kHeading} + kRow + kRow);
  EXPECT_EQ(to_csv(parse_user_study(text_of(folder / "user_test_2.json")), false), kRow);
  fs::remove_all(folder.parent_path());
}

TEST(UserStudy, ReportsThatItCannotBeSaved) {
  EXPECT_THROW((void)save(parse_user_study(kTest), "/proc/nowhere"), std::runtime_error);
}

TEST(UserStudy, RefusesInvalidStudies) {
  const std::string good = kTest;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = good;
    return changed.replace(changed.find(from), from.size(), to);
  };
  for (const auto& text :
       {std::string{}, std::string{"[]"}, std::string{R"({"person":1,"trials":[]})"},
        with("\"task\":2", "\"task\":3"), with("shared", "=cmd()"), with("18.25", "-1"),
        with("18.25", "1e999"), with("true", "1"), with("\"person\":3", "\"person\":\"Ann\"")})
    EXPECT_THROW((void)parse_user_study(text), std::invalid_argument) << text;
}

// Parsed tests are valid, and all others are refused in the same way.
TEST(UserStudy, TakesAnyBytes) {
  const std::vector<std::string> texts{kTest};
  std::mt19937 random{7};
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = test::damaged(texts, random);
    try {
      for (const auto& trial : parse_user_study(text).trials) EXPECT_LE(trial.time, 3600.0);
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace tandem
