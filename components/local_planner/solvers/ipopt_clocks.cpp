// SPDX-License-Identifier: Apache-2.0
// Replaces Ipopt's clocks; see TANDEM_IPOPT_WITHOUT_CLOCKS in CMakeLists.txt.
#include <IpUtils.hpp>

namespace Ipopt {
Number CpuTime() { return 0.0; }
Number SysTime() { return 0.0; }
Number WallclockTime() { return 0.0; }
}  // namespace Ipopt
