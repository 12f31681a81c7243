// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace tandem::test {

/// True if a sanitizer watches. Such code is ten to forty times as slow: it runs every test, with
/// fewer samples; how good the results are is asked of the code that robots run.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kInstrumented = true;
#else
inline constexpr bool kInstrumented = false;
#endif

/// How many samples to take.
constexpr unsigned samples(unsigned usual, unsigned instrumented) {
  return kInstrumented ? instrumented : usual;
}

/// The same; `in_long` of them where TANDEM_TEST_LONG is set.
inline unsigned samples(unsigned usual, unsigned instrumented, unsigned in_long) {
  return std::getenv("TANDEM_TEST_LONG") != nullptr ? in_long : samples(usual, instrumented);
}

}  // namespace tandem::test
