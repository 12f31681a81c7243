// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace tandem::test {

/// True under a sanitizer. Instrumented code is 10 to 40 times slower: it runs every test with
/// fewer samples, and the quality of results is checked only in uninstrumented builds.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kInstrumented = true;
#else
inline constexpr bool kInstrumented = false;
#endif

/// Number of samples to take.
constexpr unsigned samples(unsigned usual, unsigned instrumented) {
  return kInstrumented ? instrumented : usual;
}

/// The same, but `in_long` samples if TANDEM_TEST_LONG is set.
inline unsigned samples(unsigned usual, unsigned instrumented, unsigned in_long) {
  return std::getenv("TANDEM_TEST_LONG") != nullptr ? in_long : samples(usual, instrumented);
}

}  // namespace tandem::test
