// SPDX-License-Identifier: Apache-2.0
// Like faults_test.cpp, for faults of the machine itself. A separate program, because no other
// timing-sensitive test may run at the same time.
#include <algorithm>
#include <memory>
#include <thread>

#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

// Two CPU-bound processes per core.
TEST_F(Faults, OfTheMachine) {
  const auto hogs = std::make_shared<std::vector<std::unique_ptr<ChildProcess>>>();
  const auto begin = [hogs] {
    for (unsigned i = 0; i < 2 * std::max(1U, std::thread::hardware_concurrency()); ++i)
      hogs->push_back(std::make_unique<ChildProcess>(
          "/bin/sh", std::vector<std::string>{"-c", "while :; do :; done"}));
  };
  suffer({{"all CPU time wanted by others", begin, [hogs] { hogs->clear(); }}});
}

}  // namespace
}  // namespace tandem::test
