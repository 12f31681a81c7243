// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/stop_words.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace tandem {
namespace {

constexpr StopWords::Sender kPage{1}, kButton{2};

void leaves(StopWords& words, const StopWords::Sender& sender) {
  words.update_presence([&](const auto& other) { return other != sender; });
}

TEST(StopWords, AreTheLastMessageOfEachPublisher) {
  StopWords words;
  EXPECT_FALSE(words.pressed());
  EXPECT_TRUE(words.on_word(kPage, 1, true));
  EXPECT_TRUE(words.pressed());
  EXPECT_TRUE(words.on_word(kPage, 2, false));
  EXPECT_FALSE(words.pressed());
}

TEST(StopWords, ARepetitionIsNotNew) {
  StopWords words;
  EXPECT_TRUE(words.on_word(kPage, 1, true));
  EXPECT_TRUE(words.on_word(kPage, 2, false));
  EXPECT_FALSE(words.on_word(kPage, 1, true));
  EXPECT_FALSE(words.on_word(kPage, 2, false));
  EXPECT_FALSE(words.pressed());
}

// A press that one reader lost and another delivers late still counts as a press.
TEST(StopWords, AnOlderSampleIsNewButOverrulesNoYoungerOne) {
  StopWords words;
  EXPECT_TRUE(words.on_word(kPage, 2, false));
  EXPECT_TRUE(words.on_word(kPage, 1, true));
  EXPECT_FALSE(words.pressed());
  EXPECT_FALSE(words.on_word(kPage, 1, true));
}

TEST(StopWords, AreNotWithdrawnByAnotherPublisherWhileOnePresses) {
  StopWords words;
  words.on_word(kButton, 1, true);
  words.on_word(kPage, 1, true);
  words.on_word(kPage, 2, false);
  EXPECT_TRUE(words.pressed());
  words.on_word(kButton, 2, false);
  EXPECT_FALSE(words.pressed());
}

TEST(StopWords, OfADisconnectedPublisherStayUntilAnySendsFalse) {
  StopWords words;
  words.on_word(kButton, 1, true);
  words.on_word(kPage, 1, false);  // before it left
  leaves(words, kButton);
  EXPECT_TRUE(words.pressed());
  EXPECT_FALSE(words.on_word(kPage, 1, false)) << "the same once more";
  EXPECT_TRUE(words.pressed());
  words.on_word(kPage, 2, false);
  EXPECT_FALSE(words.pressed());
}

TEST(StopWords, OfADisconnectedPublisherStayWithdrawn) {
  StopWords words;
  words.on_word(kButton, 1, true);
  leaves(words, kButton);
  words.on_word(kPage, 1, false);
  EXPECT_FALSE(words.on_word(kButton, 1, true)) << "by a slower reader";
  EXPECT_FALSE(words.pressed());
}

// Simulates a network outage so long that DDS dropped the other side.
TEST(StopWords, OneThatReturnsCountsAgain) {
  StopWords words;
  words.on_word(kButton, 7, true);
  leaves(words, kButton);
  words.on_word(kPage, 1, false);
  EXPECT_FALSE(words.pressed());
  words.update_presence([](const auto&) { return true; });
  EXPECT_TRUE(words.on_word(kButton, 7, true)) << "latched, so sent again";
  EXPECT_TRUE(words.pressed());
  words.on_word(kPage, 2, false);
  EXPECT_TRUE(words.pressed());
}

TEST(StopWords, OfManyThatPressedAndLeftOneStays) {
  StopWords words;
  words.on_word(kButton, 1, true);
  leaves(words, kButton);
  for (int i = 0; i < 5000; ++i) {
    const StopWords::Sender sender{3, static_cast<std::uint8_t>(i),
                                   static_cast<std::uint8_t>(i >> 8)};
    words.on_word(sender, 1, true);
    words.update_presence([&](const auto&) { return false; });
  }
  EXPECT_TRUE(words.pressed());
  words.on_word(kPage, 1, false);
  EXPECT_FALSE(words.pressed());
}

// Three readers, each of which loses samples and delivers the rest in order, at any time.
TEST(StopWords, AreTheSameInAnyOrderOfDelivery) {
  std::mt19937 random{1};
  for (int drive = 0; drive < 2000; ++drive) {
    std::vector<bool> said(20);
    for (auto&& word : said) word = random() % 2 == 0;
    std::vector<bool> is_lost(said.size() * 3);
    for (auto&& lost : is_lost) lost = random() % 3 == 0;
    std::vector<std::size_t> next(3, 0);
    std::vector<int> times_new(said.size(), 0);
    StopWords words;
    std::size_t newest = 0;
    while (next != std::vector<std::size_t>(3, said.size())) {
      const std::size_t reader = random() % 3;
      if (next[reader] == said.size()) continue;
      const std::size_t sample = next[reader]++;
      if (is_lost[3 * sample + reader]) continue;
      times_new[sample] += words.on_word(kPage, sample + 1, said[sample]);
      newest = std::max(newest, sample);
      ASSERT_EQ(words.pressed(), said[newest]);
    }
    for (std::size_t sample = 0; sample < said.size(); ++sample) {
      const auto lost = is_lost.begin() + static_cast<std::ptrdiff_t>(3 * sample);
      const bool heard = std::find(lost, lost + 3, false) != lost + 3;
      EXPECT_EQ(times_new[sample], heard ? 1 : 0);
    }
  }
}

}  // namespace
}  // namespace tandem
