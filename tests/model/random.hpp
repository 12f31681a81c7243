// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

namespace tandem::test {

using Random = std::mt19937;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace tandem::test
