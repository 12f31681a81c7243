// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/thread_limit.hpp"

#include <sys/resource.h>

#include <latch>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include <spdlog/fmt/fmt.h>

namespace tandem::runtime {
namespace {

std::string process_limit() {
  rlimit limit{};
  getrlimit(RLIMIT_NPROC, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "unlimited" : fmt::format("{}", limit.rlim_cur);
}

}  // namespace

void require_threads(int count) {
  std::latch end{1};
  std::vector<std::jthread> threads;
  try {
    for (int i = 0; i < count; ++i) threads.emplace_back([&end] { end.wait(); });
  } catch (const std::system_error&) {
    end.count_down();
    throw std::runtime_error(
        fmt::format("DDS needs {} threads, but the system allows this process only {}; raise "
                    "`ulimit -u` (now {}) or the container's process limit",
                    count, threads.size(), process_limit()));
  }
  end.count_down();
}

}  // namespace tandem::runtime
