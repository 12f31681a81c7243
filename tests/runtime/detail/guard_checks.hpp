// SPDX-License-Identifier: Apache-2.0
// What the tests of the datagram guard share.
#pragma once

#include <gtest/gtest.h>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem::test {

inline constexpr runtime::GuardLimits kLimits{.sample_size = 1U << 20, .discovery_size = 1U << 16};

inline runtime::Drop check(const Octets& octets) {
  return runtime::check_datagram(octets, kLimits);
}
inline runtime::Drop check(const Datagram& datagram) { return check(datagram.octets()); }

/// Every statement about a datagram must hold in both byte orders: the parameter says whether the
/// datagram is little-endian.
class InBothOrders : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Datagram datagram() { return Datagram{GetParam()}; }
};

}  // namespace tandem::test
