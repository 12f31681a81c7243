// SPDX-License-Identifier: Apache-2.0
// safety_filter_rollouts [STEPS [FIRST_SEED]]: runs the property test on all cores for STEPS steps
// (default 1e8), plus a tenth of that from within the margin and a tenth among people, and then
// shows what happens beyond the bounds.
// Exit status 1 on a contact within the bounds.
#include "safety_filter/inside_rollouts.hpp"
#include "safety_filter/people_rollouts.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>

namespace tandem::test {
namespace {

constexpr double kStepsBeyond = 5e4;

void print(const char* what, const Tally& tally);

// A long run prints its state at every twentieth, so that an interrupted run is not lost.
constexpr double kLongRun = 1e6;  // steps
constexpr double kTellEvery = 0.05;

template <class Scene>
Tally run(const char* what, double steps, unsigned first_seed, Scene scene) {
  Tally all;
  std::mutex mutex;
  std::atomic<unsigned> next{first_seed};
  double tell = steps < kLongRun ? steps : kTellEvery * steps;
  const auto work = [&] {
    for (;;) {
      const Tally tally = scene(next++);
      const std::lock_guard lock{mutex};
      all.add(tally);
      const auto done = static_cast<double>(all.steps);
      if (done >= steps) return;
      if (done < tell) continue;
      tell += kTellEvery * steps;
      print(("so far, " + std::string{what}).c_str(), all);
    }
  };
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
    workers.emplace_back(work);
  workers.clear();
  print(what, all);
  return all;
}

void print(const char* what, const Tally& tally) {
  std::printf("%-34s %10ld steps %8ld rollouts  contacts %ld (%.3f %%)", what, tally.steps,
              tally.rollouts, tally.contacts,
              100.0 * static_cast<double>(tally.contacts) / static_cast<double>(tally.rollouts));
  if (tally.closest_seed > 0)  // not measured among people
    std::printf("  smallest clearance %.4f m (scene %u)", tally.min_clearance, tally.closest_seed);
  std::printf("\n");
  if (tally.contacts > 0) std::printf("%-34s one in scene %u\n", "", tally.contact_seed);
  std::fflush(stdout);
}

void print_beyond() {
  std::printf("\nbeyond the bounds (contacts per rollout):\n");
  for (const double factor : {1.5, 2.0, 4.0, 8.0}) {
    const auto row = [&](const char* what, const Beyond& beyond) {
      char text[64];
      std::snprintf(text, sizeof text, "%s %.1f times the bound", what, factor);
      run(text, kStepsBeyond, 1, [&](unsigned seed) { return run_scene(seed, beyond); });
    };
    row("slip", {.slip = factor});
    row("lag", {.lag = factor});
    row("delays", {.delay = factor});
    row("pose error", {.pose_error = factor});
    row("braking weaker,", {.braking = factor});
  }
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  using namespace tandem::test;
  const double steps = argc > 1 ? std::atof(argv[1]) : 1e8;
  const unsigned first = argc > 2 ? static_cast<unsigned>(std::atol(argv[2])) : 1;
  if (!(steps >= 1.0)) {
    std::fprintf(stderr, "safety_filter_rollouts [STEPS [FIRST_SEED]]: STEPS must be 1 or more\n");
    return 2;
  }
  const Tally tally =
      run("within the bounds", steps, first, [](unsigned seed) { return run_scene(seed); });
  const Tally inside = run("from within the margin", 0.1 * steps, first,
                           [](unsigned seed) { return run_inside_scene(seed); });
  const Tally people =
      run("among people", 0.1 * steps, first, [](unsigned seed) { return run_people_scene(seed); });
  std::printf("%-34s walked into %ld times while it stood, %.1f m per scene\n", "",
              people.walked_into, people.travel / static_cast<double>(people.rollouts));
  if (steps >= 1e6) print_beyond();
  return tally.contacts + inside.contacts + people.contacts == 0 && tally.unfinished == 0 ? 0 : 1;
}
