// SPDX-License-Identifier: Apache-2.0
// As faults_test.cpp: what goes wrong with the machine below them. A program of its own, for
// nothing else that looks at the clock may run beside it.
#include <algorithm>
#include <memory>
#include <thread>

#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

// Two processes for each core that want all of it.
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
