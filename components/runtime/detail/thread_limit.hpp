// SPDX-License-Identifier: Apache-2.0
// Checks that this user can start the threads that DDS needs. Private to runtime/.
#pragma once

namespace tandem::runtime {

/// Throws std::runtime_error that names the limit unless `count` threads can be started now.
/// If a thread of its own fails to start, Fast DDS 2.9 calls std::terminate in a destructor.
void require_threads(int count);

}  // namespace tandem::runtime
