// SPDX-License-Identifier: Apache-2.0
// Measures the latency from /joy to /cmd_vel over DDS, with each component as a separate node.
// Prints quantiles for policy manual and policy shared, the latter with method intention: the
// leader has to move away from the robot before the robot follows.
#include <cstdio>

#include "benchmark/latency_stick.hpp"
#include "bringup/system/system.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"

namespace tandem {
namespace {

constexpr int kPushes = 150;
void measure(const char* policy) {
  System system = load_system(test::source_path("bringup/systems/teleop.yaml"));
  for (SystemNode& node : system.nodes) {
    auto& values = node.options.parameters.values;
    if (node.component == "arbitration") values["policy"] = {policy, "latency_benchmark"};
    if (node.component == "local_planner") values["method"] = {"intention", "latency_benchmark"};
  }
  RunningSystem running{system};
  rt::Node node{"stick"};
  Stick stick{node};
  if (!test::spin_until([&] { return stick.connected(); }, 20.0, node)) return;
  const Quantiles q = latency_of(stick, kPushes);
  running.stop();
  running.wait();
  std::printf("/joy -> /cmd_vel, policy %-7s p50 %6.1f  p95 %6.1f  p99 %6.1f  max %6.1f ms\n",
              policy, q.p50, q.p95, q.p99, q.max);
}

}  // namespace
}  // namespace tandem

int main() {
  tandem::measure("manual");
  tandem::measure("shared");
}
