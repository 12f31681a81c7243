// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tandem::test {

/// Simulated per real time. Instrumented code takes several times as long: in slow motion the same
/// bounds of simulated time can be asked of it, on two cores that others want too.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr double kSpeed = 0.5;
#else
inline constexpr double kSpeed = 1.0;
#endif

}  // namespace tandem::test
