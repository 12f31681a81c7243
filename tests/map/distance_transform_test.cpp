// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/distance_transform.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace tandem {
namespace {

using Mask = std::vector<std::uint8_t>;

Mask random_mask(int width, int height, double share, std::mt19937& random) {
  std::bernoulli_distribution is_obstacle(share);
  Mask mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (auto& cell : mask) cell = is_obstacle(random) ? 1 : 0;
  return mask;
}

// Of all obstacle squares.
double nearest(const Mask& mask, int width, int height, int x, int y) {
  double least = std::numeric_limits<double>::infinity();
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      if (mask[static_cast<std::size_t>(v * width + u)] != 0)
        least = std::min(least, std::hypot(std::max(0.0, std::abs(u - x) - 0.5),
                                           std::max(0.0, std::abs(v - y) - 0.5)));
  return least;
}

TEST(DistanceTransform, IsTheDistanceToTheNearestSquare) {
  std::mt19937 random{1};
  for (const double share : {0.0, 0.02, 0.3, 1.0}) {
    const int width = 23, height = 17;
    const Mask mask = random_mask(width, height, share, random);
    const auto found = distance_transform(mask, width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double right = nearest(mask, width, height, x, y);
        const double got = found[static_cast<std::size_t>(y * width + x)];
        if (std::isinf(right))
          EXPECT_EQ(got, right);
        else
          EXPECT_NEAR(got, right, 1e-9);
      }
  }
}

TEST(DistanceTransform, ALimitCutsOffWhatIsFarther) {
  std::mt19937 random{2};
  std::uniform_int_distribution<int> side(1, 60), limit(1, 12);
  for (int i = 0; i < 200; ++i) {
    const int width = side(random), height = side(random), most = limit(random);
    const Mask mask = random_mask(width, height, i % 2 == 0 ? 0.003 : 0.1, random);
    const auto all = distance_transform(mask, width, height);
    const auto near = distance_transform(mask, width, height, most);
    ASSERT_EQ(near.size(), all.size());
    for (std::size_t cell = 0; cell < all.size(); ++cell)
      ASSERT_EQ(near[cell], static_cast<float>(std::min<double>(all[cell], most)))
          << width << " × " << height << ", at most " << most << ", cell " << cell;
  }
}

TEST(DistanceTransform, OfNothingIsEmpty) {
  EXPECT_TRUE(distance_transform({}, 0, 0).empty());
  EXPECT_TRUE(distance_transform({}, 0, 0, 5).empty());
}

}  // namespace
}  // namespace tandem
