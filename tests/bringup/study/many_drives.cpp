// SPDX-License-Identifier: Apache-2.0
// many_drives DRIVES MEGABYTES [report]: generates shards of a study with that many drives, merges
// them with `../tandem study`, draws the report if asked to, and prints time and peak memory. Exits
// with status 1 if that takes more memory than a study of a single drive by more than MEGABYTES.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "bringup/study/study_folder.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr unsigned kShards = 8;
const std::vector<std::string> kScenarios{"forest_task1", "forest_task2", "corridor", "slalom",
                                          "ward"};
const std::vector<std::string> kMethods{"manual",    "safety_filter", "dwa",   "leader",
                                        "intention", "path",          "blend", "adaptive"};
const std::vector<std::string> kDrivers{"navigator", "navigator+tremor", "navigator+pulses",
                                        "navigator+dropouts", "pointer"};

std::vector<DriveGroup> all_groups() {
  std::vector<DriveGroup> groups;
  for (const auto& scenario : kScenarios)
    for (const auto& method : kMethods)
      for (const auto& driver : kDrivers) groups.push_back({scenario, method, driver});
  return groups;
}

// A study of `count` drives.
json study_of(std::size_t count) {
  json groups = json::array();
  const auto all = all_groups();
  for (std::size_t g = 0; g < all.size(); ++g) {
    const std::size_t seeds = (count + all.size() - 1 - g) / all.size();
    if (seeds > 0)
      groups.push_back({{"scenario", all[g].scenario},
                        {"method", all[g].method},
                        {"driver", all[g].driver},
                        {"seeds", "1-" + std::to_string(seeds)}});
  }
  return {{"study", "many"}, {"description", {{"study", "many"}}}, {"groups", groups}};
}

json drive_of(const DriveGroup& group, unsigned seed, std::mt19937& random) {
  std::lognormal_distribution<double> spread{0.0, 0.3};
  DriveResult result;
  result.scenario = group.scenario;
  result.method = group.method;
  result.driver = group.driver;
  result.seed = seed;
  result.map = "maps/" + group.scenario + ".bt";
  result.lockstep = true;
  result.reached = spread(random) < 2.0;
  result.time_to_goal_s = result.reached ? 15.0 * spread(random) : -1.0;
  result.simulated_s = 15.0 * spread(random);
  result.cpu_s = result.wall_s = 0.3 * spread(random);
  result.collisions = spread(random) > 1.5 ? 1 : 0;
  result.min_clearance_m = 0.1 * spread(random);
  result.free_time_s = 14.0 * spread(random);
  result.time_ratio = spread(random);
  result.path_ratio = 1.1 * spread(random);
  result.agreement_direction = std::min(1.0, 0.9 * spread(random));
  result.jerk_rms = 3.0 * spread(random);
  result.counts.filter_commands = result.counts.plans = 300;
  result.plan_ms = {spread(random), 3.0 * spread(random), 5.0 * spread(random), 20.0};
  json track = json::array();
  for (int i = 0; i < 70; ++i) track.push_back({0.1 * i, std::round(100.0 * spread(random)) / 100});
  return {{"drive", result},
          {"track", track},
          {"contacts", json::array({{1.0, 1.0}})},
          {"cost_s", 2.0 * result.cpu_s}};
}

// A few cells, to draw the tracks in.
json worlds() {
  json all;
  for (const auto& scenario : kScenarios)
    all[scenario] = {
        {"start", {0.0, 1.0, 0.0}},
        {"outline", {{{-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}, {-0.3, 0.2}}}},
        {"goal", {{"region", {6.0, 0.0, 7.0, 2.0}}}},
        {"worlds",
         {{scenario + ".bt", {{"resolution", 0.1}, {"cells", {{-1.0, -1.0}, {8.0, 4.0}}}}}}}};
  return all;
}

void generate(const fs::path& folder, std::size_t count) {
  const json study = study_of(count);
  for (unsigned shard = 0; shard < kShards; ++shard) {
    StudyFolder out{folder / std::to_string(shard), study};
    std::mt19937 random{shard};
    out.results().add_many([&] {
      for (const PlannedGroup& planned : out.groups())
        for (const unsigned seed : planned.seeds)
          if (seed % kShards == shard) out.results().add(drive_of(planned.group, seed, random));
    });
    write_file(out.path() + "/worlds.json", worlds().dump());
  }
}

// Runs `../tandem` and returns the largest memory that it or a process of its took [MB].
double memory_of(const std::vector<std::string>& words) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<char*> arguments;
  for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen("/dev/null", "w", stdout) != nullptr) execv("../tandem", arguments.data());
    std::_Exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (status != 0) std::exit(1);
  const double memory = static_cast<double>(usage.ru_maxrss) / 1024.0;
  std::printf("study %s: %.0f s, %.0f MB\n", words[2].c_str(),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
              memory);
  return memory;
}

// Largest memory of merging a study of `count` drives and, if wanted, of reporting it [MB].
double measure(const fs::path& folder, std::size_t count, bool with_report) {
  generate(folder, count);
  const std::string merged = folder / "merged";
  std::vector<std::string> merge{"tandem", "study", "merge", merged};
  for (unsigned shard = 0; shard < kShards; ++shard)
    merge.push_back(folder / std::to_string(shard));
  merge.emplace_back("--no-report");
  std::printf("%zu drives\n", count);
  const double merging = memory_of(merge);
  return with_report ? std::max(merging, memory_of({"tandem", "study", "report", merged}))
                     : merging;
}

int run(std::size_t count, double allowed, bool with_report) {
  const fs::path folder =
      fs::temp_directory_path() / ("tandem_many_drives_" + std::to_string(getpid()));
  const double least = measure(folder / "one", 1, with_report);
  const double most = measure(folder / "many", count, with_report);
  fs::remove_all(folder);
  std::printf("%.0f MB more than for one drive; allowed are %.0f\n", most - least, allowed);
  return most - least > allowed ? 1 : 0;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  const bool with_report = argc == 4 && std::string{argv[3]} == "report";
  if (argc != 3 && !with_report) {
    std::fprintf(stderr, "usage: many_drives DRIVES MEGABYTES [report]\n");
    return 1;
  }
  return tandem::run(std::stoul(argv[1]), std::stod(argv[2]), with_report);
}
