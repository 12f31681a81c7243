// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/transit.hpp"

#include <algorithm>

namespace tandem::runtime {

bool Transit::is_late(double sent, double taken, double lifespan) {
  const double transit = taken - sent;
  if (known_) least_ += kDrift * std::max(0.0, taken - last_);
  last_ = taken;
  if (!known_ || transit < least_) least_ = transit;
  known_ = true;
  if (transit - least_ <= lifespan) return late_ = false;
  if (!late_) late_since_ = taken;
  late_ = true;
  if (taken - late_since_ <= kForGood) return true;
  least_ = transit;
  return late_ = false;
}

}  // namespace tandem::runtime
