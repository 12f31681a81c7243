// SPDX-License-Identifier: Apache-2.0
// Measures the latency from /joy to /cmd_vel with one process per node and policy manual,
// alternately without and with DDS Security, twice each. Prints quantiles.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "benchmark/latency_stick.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/secured_domain.hpp"

namespace tandem {
namespace {

constexpr int kPushes = 110;

void measure(bool secured) {
  const std::string file = test::source_path("bringup/systems/teleop.yaml");
  std::optional<test::SecuredDomain> domain;
  if (secured) domain.emplace().add_system(file);
  std::vector<std::unique_ptr<test::ChildProcess>> processes;
  for (const std::string name :
       {"map_server", "teleop", "arbitration", "safety_filter", "diff_drive_sim"}) {
    std::vector<std::string> arguments{"run", file, "--only", name, "--enclave", "/" + name};
    if (name == "arbitration")
      arguments.insert(arguments.end(), {"--ros-args", "-p", "policy:=manual"});
    processes.push_back(std::make_unique<test::ChildProcess>("../tandem", std::move(arguments)));
  }
  rt::Node node{"watcher"};
  Stick stick{node};
  if (!test::spin_until([&] { return stick.connected(); }, 20.0, node)) {
    std::printf("the system does not start\n");
    return;
  }
  const Quantiles q = latency_of(stick, kPushes);
  std::printf("/joy -> /cmd_vel, %-7s p50 %6.2f  p95 %6.2f  p99 %6.2f  max %6.2f ms\n",
              secured ? "secured" : "open", q.p50, q.p95, q.p99, q.max);
}

}  // namespace
}  // namespace tandem

int main() {
  setenv("TANDEM_LOG_LEVEL", "error", 0);
  tandem::rt::set_log_to_stderr(false);
  for (int round = 0; round < 2; ++round)
    for (const bool secured : {false, true}) tandem::measure(secured);
}
