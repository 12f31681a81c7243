// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: whether this user may start the threads that DDS needs.
#pragma once

namespace tandem::runtime {

/// Throws std::runtime_error that names the limit unless `count` threads can be started now.
/// Fast DDS 2.9 ends the process where one of its own cannot (std::terminate in a destructor).
void require_threads(int count);

}  // namespace tandem::runtime
