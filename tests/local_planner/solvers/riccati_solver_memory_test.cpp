// SPDX-License-Identifier: Apache-2.0
// Counts every allocation of the process: a program of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "local_planner/planning_cases.hpp"
#include "tandem/local_planner/solvers/riccati_solver.hpp"

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace tandem::test {
namespace {

TEST(RiccatiSolver, AllocatesNothingOnceItHasSolvedALargerProblem) {
  std::vector<StartingPoint> starts;
  for (unsigned seed = 0; seed < 100; ++seed)
    for (const bool blind : {false, true})
      starts.push_back(first_problem(random_case(seed), blind));
  RiccatiSolver solver;
  const SolveLimits limits{.iterations = 300};
  for (const StartingPoint& start : starts) (void)solver.solve(start.ocp, start.guess, limits);
  for (const StartingPoint& start : starts) {
    const long before = allocations;
    const Solution& solution = solver.solve(start.ocp, start.guess, limits);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(solution.status, SolveStatus::kConverged);
  }
}

}  // namespace
}  // namespace tandem::test
