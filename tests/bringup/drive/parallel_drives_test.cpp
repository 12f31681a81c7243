// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/parallel_drives.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace tandem {
namespace {

// What comes back of `count` pieces; and what is complained of.
struct Outcome {
  std::map<std::size_t, nlohmann::json> results;
  std::string complaint;
};

Outcome outcome(std::size_t count, unsigned workers,
                const std::function<nlohmann::json(std::size_t)>& work) {
  Outcome outcome;
  try {
    work_side_by_side(count, workers, work, [&](std::size_t i, const nlohmann::json& result) {
      EXPECT_TRUE(outcome.results.emplace(i, result).second) << i << " came twice";
    });
  } catch (const std::runtime_error& error) {
    outcome.complaint = error.what();
  }
  return outcome;
}

TEST(WorkSideBySide, DoesEachPieceOnceByOtherProcesses) {
  const auto all = outcome(100, 3, [](std::size_t i) {
    return nlohmann::json{{"i", i}, {"pid", getpid()}, {"text", std::string(i * 50, 'x')}};
  });
  EXPECT_EQ(all.complaint, "");
  ASSERT_EQ(all.results.size(), 100u);
  for (const auto& [i, result] : all.results) {
    EXPECT_EQ(result.at("i"), i);
    EXPECT_EQ(result.at("text").get<std::string>().size(), i * 50);
    EXPECT_NE(result.at("pid"), getpid());
  }
}

TEST(WorkSideBySide, HasNothingToDoWithoutPieces) {
  EXPECT_TRUE(outcome(0, 4, [](std::size_t) { return nlohmann::json{}; }).results.empty());
}

TEST(WorkSideBySide, APieceThatThrowsIsNamedAndDoesNotAffectOthers) {
  const auto all = outcome(20, 2, [](std::size_t i) -> nlohmann::json {
    if (i == 5) throw std::runtime_error("five is wrong");
    return i;
  });
  EXPECT_EQ(all.results.size(), 19u);
  EXPECT_EQ(all.complaint, "1 of 20 drives failed; the first error: five is wrong");
}

TEST(WorkSideBySide, APieceWhoseProcessDiesDoesNotAffectOthers) {
  const auto all = outcome(20, 2, [](std::size_t i) -> nlohmann::json {
    if (i == 5) raise(SIGKILL);
    return i;
  });
  EXPECT_EQ(all.results.size(), 19u);
  EXPECT_FALSE(all.results.contains(5));
  EXPECT_EQ(
      all.complaint,
      "1 of 20 drives failed; the first error: the process of drive number 6 died from signal 9");
}

TEST(WorkSideBySide, LeavesNoProcessWhenTheReceiverThrows) {
  EXPECT_THROW(work_side_by_side(
                   4, 2,
                   [](std::size_t i) -> nlohmann::json {
                     if (i > 0) pause();
                     return i;
                   },
                   [](std::size_t, const nlohmann::json&) { throw std::logic_error("no room"); }),
               std::logic_error);
  EXPECT_EQ(waitpid(-1, nullptr, 0), -1);
}

}  // namespace
}  // namespace tandem
