// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/instrumented.hpp"

namespace tandem::test {

/// Simulated time per real time. Instrumented code is several times slower; in slow motion it can
/// meet the same bounds in simulated time, even on two shared cores.
inline constexpr double kSpeed = kInstrumented ? 0.5 : 1.0;

}  // namespace tandem::test
