// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/range_returns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace tandem {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

RangeScan scan(std::span<const float> ranges) {
  return {.angle_min = -0.1,
          .angle_increment = 0.1,
          .range_min = 0.2,
          .range_max = 5.0,
          .ranges = ranges};
}

TEST(RangeScan, ReturnsLieOnTheirBeams) {
  const std::vector<float> ranges{1.0F, 2.0F, 4.0F};
  const RangeReturns echoes = range_returns_of(scan(ranges));
  ASSERT_EQ(echoes.p_SQ.size(), 3U);
  EXPECT_TRUE(echoes.p_SFree.empty());
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = -0.1 + 0.1 * static_cast<double>(i);
    const Eigen::Vector3d expected{ranges[i] * std::cos(angle), ranges[i] * std::sin(angle), 0.0};
    EXPECT_LT((echoes.p_SQ[i] - expected).norm(), 1e-6);
  }
}

TEST(RangeScan, NoReturnMeansFreeSpaceAndInvalidRangesMeanNothing) {
  const std::vector<float> ranges{kInfinity, 9.0F, kNaN, -kInfinity, 0.0F, 0.19F, -1.0F};
  const RangeReturns echoes = range_returns_of(scan(ranges));
  EXPECT_TRUE(echoes.error.empty());
  EXPECT_TRUE(echoes.p_SQ.empty());
  ASSERT_EQ(echoes.p_SFree.size(), 1U);  // +inf
  EXPECT_NEAR(echoes.p_SFree[0].norm(), 5.0, 1e-9);
}

// A driver may set range_max to the farthest reading: a flat wall must not look like free space.
TEST(RangeScan, AReadingOfExactlyRangeMaxIsAReturn) {
  const std::vector<float> ranges{5.0F, 5.0F};
  EXPECT_EQ(range_returns_of(scan(ranges)).p_SQ.size(), 2U);
}

TEST(RangeScan, NoReturnDefinesWhatMeansNothingInRange) {
  const std::vector<float> ranges{kInfinity, 5.0F, 9.0F, 0.0F, kNaN, 2.0F};
  struct Case {
    std::vector<std::string> names;
    std::size_t echoes, free;
  };
  for (const Case& c : {Case{{}, 2, 0}, Case{{"inf"}, 2, 1}, Case{{"range_max"}, 1, 2},
                        Case{{"zero"}, 2, 1}, Case{{"nan"}, 2, 1}, Case{kNoReturnNames, 1, 5}}) {
    const RangeReturns echoes = range_returns_of(scan(ranges), no_return_of(c.names));
    EXPECT_EQ(echoes.p_SQ.size(), c.echoes) << c.names.size();
    EXPECT_EQ(echoes.p_SFree.size(), c.free) << c.names.size();
    for (const auto& p : echoes.p_SFree) EXPECT_NEAR(p.norm(), 5.0, 1e-9);
  }
}

// pointcloud_to_laserscan's default.
TEST(RangeScan, RangeMaxMayBeInfinite) {
  const std::vector<float> ranges{kInfinity, 20.0F};
  RangeScan endless = scan(ranges);
  endless.range_max = std::numeric_limits<double>::infinity();
  const RangeReturns echoes = range_returns_of(endless);
  EXPECT_TRUE(echoes.error.empty());
  ASSERT_EQ(echoes.p_SQ.size(), 1U);
  ASSERT_EQ(echoes.p_SFree.size(), 1U);
  EXPECT_TRUE(echoes.p_SFree[0].allFinite());
}

TEST(RangeScan, BeamsAreNotTakenBackwardsNorForLongerThanTheScan) {
  const std::vector<float> ranges(100, 2.0F);
  RangeScan sweep = scan(ranges);
  sweep.time_increment = 0.001;
  EXPECT_TRUE(time_error_of(sweep).empty());
  sweep.scan_time = 0.1;
  EXPECT_TRUE(time_error_of(sweep).empty());
  sweep.scan_time = 0.05;
  EXPECT_NE(time_error_of(sweep).find("time_increment = 0.001"), std::string::npos);
  for (const double increment : {153333.0, -0.001}) {
    sweep.time_increment = increment;
    for (const double scan_time : {0.0, 0.1, 1e9}) {
      sweep.scan_time = scan_time;
      EXPECT_NE(time_error_of(sweep).find("time_increment"), std::string::npos) << scan_time;
    }
  }
}

TEST(RangeScan, RefusesAScanWithoutMeaning) {
  const std::vector<float> ranges{1.0F};
  for (const auto& spoil : std::vector<void (*)(RangeScan&)>{
           [](RangeScan& s) { s.angle_min = std::nan(""); },
           [](RangeScan& s) { s.angle_increment = std::nan(""); },
           [](RangeScan& s) { s.range_min = -0.1; }, [](RangeScan& s) { s.range_max = 0.1; },
           [](RangeScan& s) { s.range_max = std::nan(""); },
           [](RangeScan& s) { s.time_increment = std::nan(""); }}) {
    RangeScan bad = scan(ranges);
    spoil(bad);
    const RangeReturns echoes = range_returns_of(bad);
    EXPECT_FALSE(echoes.error.empty());
    EXPECT_TRUE(echoes.p_SQ.empty() && echoes.p_SFree.empty());
  }
}

// Points in a typical driver's layout: intensity first, so that no offset is zero by chance.
struct Cloud {
  CloudLayout layout;
  std::vector<std::uint8_t> data;
};

template <class Float>
void put(std::uint8_t* to, Float value, bool big) {
  auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(Float)>>(value);
  if (big != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  std::copy(bytes.begin(), bytes.end(), to);
}

template <class Float>
Cloud cloud(const std::vector<Eigen::Vector3d>& points, std::uint32_t width, bool big,
            std::uint32_t padding) {
  constexpr std::uint32_t kSize = sizeof(Float);
  constexpr std::uint8_t kType = kSize == 4 ? 7 : 8;
  Cloud out;
  const auto count = static_cast<std::uint32_t>(points.size());
  out.layout = {.height = count / width,
                .width = width,
                .fields = {{"intensity", 0, 2},
                           {"x", 4, kType},
                           {"z", 4 + kSize, kType},
                           {"y", 4 + 2 * kSize, kType}},
                .is_bigendian = big,
                .point_step = 4 + 3 * kSize + 2,
                .row_step = width * (4 + 3 * kSize + 2) + padding};
  out.data.resize(std::size_t{out.layout.height} * out.layout.row_step, 0xEE);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint8_t* point =
        &out.data[i / width * out.layout.row_step + i % width * out.layout.point_step];
    put(point + 4, static_cast<Float>(points[i].x()), big);
    put(point + 4 + kSize, static_cast<Float>(points[i].z()), big);
    put(point + 4 + 2 * kSize, static_cast<Float>(points[i].y()), big);
  }
  return out;
}

std::vector<Eigen::Vector3d> some_points() {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 12; ++i) points.emplace_back(0.5 * i, 0.25 - i, 0.125 * i);
  return points;
}

void expect_points(const Cloud& cloud, const std::vector<Eigen::Vector3d>& points) {
  const RangeReturns echoes = range_returns_of(cloud.layout, cloud.data);
  EXPECT_EQ(echoes.error, "");
  EXPECT_EQ(echoes.p_SQ, points);
}

TEST(PointCloud, IsReadByItsFieldsInEitherByteOrderAndPrecision) {
  for (const bool big : {false, true})
    for (const std::uint32_t padding : {0U, 5U}) {
      expect_points(cloud<float>(some_points(), 4, big, padding), some_points());
      expect_points(cloud<double>(some_points(), 12, big, padding), some_points());
    }
}

TEST(PointCloud, NonFinitePointsAreIgnored) {
  auto points = some_points();
  auto with_bad = points;
  with_bad[3].y() = std::nan("");
  with_bad[7].z() = kInfinity;
  points.erase(points.begin() + 7);
  points.erase(points.begin() + 3);
  expect_points(cloud<float>(with_bad, 4, false, 0), points);
}

TEST(PointCloud, AnEmptyCloudIsValid) {
  Cloud empty = cloud<float>(some_points(), 4, false, 0);
  empty.layout.width = empty.layout.height = 0;
  empty.data.clear();
  expect_points(empty, {});
}

TEST(PointCloud, RefusesALayoutThatDoesNotMatchItsBytes) {
  const Cloud good = cloud<float>(some_points(), 4, false, 0);
  for (const auto& spoil : std::vector<void (*)(Cloud&)>{
           [](Cloud& c) { c.layout.fields[1].name = "a"; },
           [](Cloud& c) { c.layout.fields.clear(); },
           [](Cloud& c) { c.layout.fields[1].datatype = 4; },
           [](Cloud& c) { c.layout.fields[2].offset = c.layout.point_step - 3; },
           [](Cloud& c) { c.layout.fields[2].offset = 0xFFFFFFFFU; },
           [](Cloud& c) { c.layout.point_step = 0; }, [](Cloud& c) { c.layout.row_step -= 1; },
           [](Cloud& c) { c.layout.row_step = 0xFFFFFFFFU; },
           [](Cloud& c) { c.layout.height = c.layout.width = 0xFFFFFFFFU; },
           [](Cloud& c) { c.layout.height += 1; }, [](Cloud& c) { c.layout.width += 1; },
           [](Cloud& c) { c.data.pop_back(); }, [](Cloud& c) { c.data.clear(); }}) {
    Cloud bad = good;
    spoil(bad);
    const RangeReturns echoes = range_returns_of(bad.layout, bad.data);
    EXPECT_FALSE(echoes.error.empty());
    EXPECT_EQ(echoes.error.find('\n'), std::string::npos);
    EXPECT_TRUE(echoes.p_SQ.empty());
  }
}

// Under the address sanitizer this shows that no layout reads beyond its bytes.
TEST(PointCloud, AnyLayoutIsSafe) {
  std::mt19937 random{1};
  const auto number = [&](std::uint32_t most) {
    return random() % 8 == 0 ? static_cast<std::uint32_t>(random())
                             : static_cast<std::uint32_t>(random() % most);
  };
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    CloudLayout layout{.height = number(5),
                       .width = number(5),
                       .fields = {},
                       .is_bigendian = random() % 2 == 0,
                       .point_step = number(40),
                       .row_step = number(200)};
    for (const char* name : {"x", "y", "z"})
      layout.fields.push_back({name, number(30), static_cast<std::uint8_t>(7 + random() % 2)});
    const std::vector<std::uint8_t> data(random() % 400, 0x3F);
    const RangeReturns echoes = range_returns_of(layout, data);
    if (echoes.error.empty()) ++accepted;
    EXPECT_LE(echoes.p_SQ.size(), std::uint64_t{layout.height} * layout.width);
  }
  EXPECT_GT(accepted, 500);
}

}  // namespace
}  // namespace tandem
