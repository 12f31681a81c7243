// SPDX-License-Identifier: Apache-2.0
// Checks that this user can start the threads that DDS needs. Private to runtime/.
#pragma once

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Throws std::runtime_error naming the limit if `count` threads cannot be started now. Fast
/// DDS 2.9 calls std::terminate in a destructor if one of its own threads fails to start.
TANDEM_EXPORT_FOR_TESTS void require_threads(int count);

}  // namespace tandem::runtime
