// SPDX-License-Identifier: Apache-2.0
// Prints shapes against lost poses: `extractor_tradeoff [every]` takes every n-th BARN world.
#include <cstdio>
#include <cstdlib>

#include "obstacle_extractor/loss_worlds.hpp"
#include "tandem/local_planner/nmpc_params.hpp"

namespace tandem::test {
namespace {

struct Choice {
  double space_per_shape;
  int shapes_per_tile;
};
constexpr Choice kChoices[]{{0.02, 12}, {0.03, 12}, {0.04, 12}, {0.06, 12},  {0.1, 12},
                            {0.2, 12},  {0.03, 8},  {0.03, 16}, {0.03, 1000}};

void print(const char* world, const ExtractorParams& params, const Loss& loss) {
  std::printf("%-16s %9.2f %10d %8.1f %5d %5d %5d %9.2f %10.2f\n", world, params.space_per_shape,
              params.shapes_per_tile, loss.mean_shapes(), loss.shapes_at(0.5), loss.shapes_at(0.9),
              loss.shapes_at(1.0), 100.0 * loss.share(), 100.0 * loss.share_to_discs());
  std::fflush(stdout);
}

int run(int every) {
  std::printf("%-16s %9s %10s %8s %5s %5s %5s %9s %10s\n", "world, robot", "m²/shape", "per tile",
              "shapes", "p50", "p90", "max", "lost %", "by discs %");
  const auto worlds = loss_worlds(every);
  for (const auto& [space, most] : kChoices) {
    const ExtractorParams params{.space_per_shape = space, .shapes_per_tile = most};
    for (const LossWorlds& group : worlds)
      print(group.name, params, group.measure(params, NmpcParams{}.disc_overhang));
  }
  return 0;
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  const int every = argc > 1 ? std::atoi(argv[1]) : 10;
  return every > 0 ? tandem::test::run(every) : 1;
}
