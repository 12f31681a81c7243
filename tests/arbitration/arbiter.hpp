// SPDX-License-Identifier: Apache-2.0
// The arbiter that the tests of its rules begin with.
#pragma once

#include "tandem/arbitration/arbiter.hpp"

namespace tandem {

inline Arbiter arbiter(const char* policy, double handover_time = 0.0) {
  return Arbiter{{.policy = policy, .handover_time = handover_time}};
}

}  // namespace tandem
