// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/instrumented.hpp"

namespace tandem::test {

/// Simulated per real time. Instrumented code takes several times as long: in slow motion the same
/// bounds of simulated time can be asked of it, on two cores that others want too.
inline constexpr double kSpeed = kInstrumented ? 0.5 : 1.0;

}  // namespace tandem::test
