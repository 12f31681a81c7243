// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace tandem {

/// Lets this process learn of everything on the domain, also behind a discovery server, which tells
/// its clients only what they need. An own value of ROS_SUPER_CLIENT is kept. Call it before the
/// first node is made, while the process has one thread.
inline void become_super_client() {
  constexpr int kKeep = 0;
  setenv("ROS_SUPER_CLIENT", "TRUE", kKeep);
}

}  // namespace tandem
