// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/scan_reader.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tandem {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kEndless = std::numeric_limits<float>::infinity();
constexpr double kNearest = 0.1;  // [m] nearer range returns are ignored

const OwnBody kSmallRobot{rectangle(0.4, 0.4, 0.0)};

RangeScan all_around(const std::vector<float>& ranges, double range_max = 10.0) {
  return {.angle_min = 0.0,
          .angle_increment = 6.28 / static_cast<double>(std::max<std::size_t>(1, ranges.size())),
          .range_min = 0.0,
          .range_max = range_max,
          .ranges = ranges};
}

ScanReading reading_of(const std::vector<float>& ranges,
                       std::vector<std::string> no_return = {"inf"}) {
  ScanReader reader{{.no_return = std::move(no_return)}, kNearest};
  return reader.read(all_around(ranges), Eigen::Isometry3d::Identity(), kSmallRobot);
}

TEST(ScanReader, BeamsWithoutInformationAreNotValid) {
  EXPECT_EQ(reading_of({0.0F, 0.0F, 0.0F, 0.0F}).valid_share, 0.0);
  EXPECT_EQ(reading_of({kNotANumber, kNotANumber}).valid_share, 0.0);
  EXPECT_EQ(reading_of({}).valid_share, 0.0);
  EXPECT_EQ(reading_of({11.0F, 11.0F}).valid_share, 0.0);
  EXPECT_EQ(reading_of({0.15F, 0.15F}).valid_share, 0.0);  // a cloth over the scanner
  EXPECT_EQ(reading_of({3.0F, kNotANumber, kNotANumber, kNotANumber}).valid_share, 0.25);
}

TEST(ScanReader, NothingInRangeIsValidIfTheDriverSendsIt) {
  EXPECT_EQ(reading_of({kEndless, kEndless}).valid_share, 1.0);  // a hall
  EXPECT_EQ(reading_of({0.0F, 0.0F}, {"zero"}).valid_share, 1.0);
  EXPECT_EQ(reading_of({kEndless, kEndless}, {"zero"}).valid_share, 0.0);
}

TEST(ScanReader, DescribesTheBeams) {
  const std::string text =
      reading_of({0.0F, 0.0F, kNotANumber, 0.15F, 3.0F, 10.0F, kEndless}).composition;
  for (const char* part : {"7 beams: ", "2 zero", "1 nan", "1 inf", "1 range_max or more",
                           "2 in range", "1 inside the outline"})
    EXPECT_NE(text.find(part), std::string::npos) << part << ": " << text;
}

// A driver that sets range_max to the farthest reading: a wall there would look like free space.
TEST(ScanReader, RangeMaxMayNotVaryWhereNoReturnNamesIt) {
  ScanReader reader{{.no_return = {"inf", "range_max"}}, kNearest};
  const auto error = [&](float range_max) {
    const std::vector<float> ranges{2.0F, range_max};
    return reader.read(all_around(ranges, range_max), Eigen::Isometry3d::Identity(), kSmallRobot)
        .error;
  };
  EXPECT_EQ(error(3.0F), "");
  EXPECT_EQ(error(3.0F), "");
  EXPECT_NE(error(2.9F).find("range_max varies"), std::string::npos);
  EXPECT_NE(error(2.9F).find("no_return"), std::string::npos);  // while the robot stands, too
  reader.forget();
  EXPECT_EQ(error(2.9F), "");
}

TEST(ScanReader, RangeMaxMayVaryWhereNoReturnDoesNotNameIt) {
  ScanReader reader{{}, kNearest};
  for (const float range_max : {3.0F, 2.9F, 2.8F}) {
    const std::vector<float> ranges{2.0F, range_max};
    const auto reading =
        reader.read(all_around(ranges, range_max), Eigen::Isometry3d::Identity(), kSmallRobot);
    EXPECT_EQ(reading.error, "");
    EXPECT_EQ(reading.seen.p_SQ.size(), 2U);  // the farthest is a range return like the others
  }
}

TEST(ScanReader, NamesOnceWhatNoReturnSeemsToLack) {
  ScanReader reader{{}, kNearest};
  const auto told = [&](const std::vector<float>& ranges, int scans) {
    std::vector<std::string> names;
    for (int i = 0; i < scans; ++i)
      if (const auto name = reader.missing_name(all_around(ranges))) names.push_back(*name);
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(told({2.0F, kEndless, kEndless}, 100), Names{});
  EXPECT_EQ(told({2.0F, 0.0F, 0.0F}, 10), Names{});  // a glitch
  EXPECT_EQ(told({2.0F, 2.0F, 0.0F}, 100), Names{});
  EXPECT_EQ(told({2.0F, 0.0F, 0.0F}, 100), Names{"zero"});
  EXPECT_EQ(told({2.0F, 10.0F, 10.0F}, 100), Names{"range_max"});
  EXPECT_EQ(told({2.0F, kNotANumber, kNotANumber}, 100), Names{"nan"});
  EXPECT_EQ(told({2.0F, 0.0F, 0.0F}, 100), Names{});
}

}  // namespace
}  // namespace tandem
