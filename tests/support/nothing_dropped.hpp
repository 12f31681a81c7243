// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "support/captured_log.hpp"

namespace tandem::test {

/// Fails if this process or one of its children logs, during this object's lifetime, that the RTPS
/// guard dropped something. The guard logs within a second of the first drop.
class NothingDropped {
 public:
  NothingDropped() = default;
  ~NothingDropped() { EXPECT_EQ(log_.lines("that were malformed or too frequent"), 0); }
  NothingDropped(const NothingDropped&) = delete;
  NothingDropped& operator=(const NothingDropped&) = delete;

 private:
  CapturedLog log_;
};

}  // namespace tandem::test
