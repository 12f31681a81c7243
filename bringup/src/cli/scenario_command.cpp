// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/scenario_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bringup/cli/progress_bar.hpp"
#include "bringup/drive/lockstep.hpp"
#include "bringup/drive/over_dds.hpp"
#include "bringup/drive/parallel_drives.hpp"
#include "bringup/drive/summary_table.hpp"
#include "bringup/scenario/method.hpp"
#include "bringup/system/shared_files.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

struct ScenarioRequest {
  std::vector<std::string> files;
  std::string method, driver, recording, recording_topic, map, json, picture, seeds;
  unsigned seed = 0;
  bool lockstep = false, dds = false, no_filter = false, quiet = false;
  double speed = 1.0;
  unsigned jobs = 1;
};

// Lists all drives. Checks each scenario with each method, so that errors appear before the first
// drive.
std::vector<DriveJob> jobs_of(const ScenarioRequest& request) {
  const auto [first, last] = request.seeds.empty() ? SeedRange{request.seed, request.seed}
                                                   : seed_range("--seeds", request.seeds);
  const std::string map = request.map.empty() ? "" : find_file(request.map, "maps");
  std::vector<DriveJob> jobs;
  for (const auto& file : request.files) {
    const Scenario scenario = load_scenario(find_file(file, "scenarios"));
    check_robot(scenario);
    const auto methods =
        request.method == "all" ? scenario.methods : std::vector<std::string>{request.method};
    for (const auto& method : methods) {
      DriveOptions options{method,           last,          map,           !request.no_filter,
                           request.lockstep, request.speed, request.driver};
      options.recording = request.recording;
      options.recording_topic = request.recording_topic;
      check_drive(scenario, options);
      for (options.seed = first; options.seed <= last; ++options.seed)
        jobs.push_back({scenario, options});
    }
  }
  return jobs;
}

// Reports an unwritable output before the first drive rather than after the last.
void check_outputs(const ScenarioRequest& request) {
  const fs::path json = request.json;
  const fs::path folder = json.has_parent_path() ? json.parent_path() : fs::path{"."};
  if (!json.empty() && (fs::is_directory(json) || access(folder.c_str(), W_OK) != 0))
    throw std::invalid_argument("--json " + request.json +
                                ": cannot be written; name a file in a folder that exists");
  if (request.picture.empty()) return;
  std::error_code error;
  fs::create_directories(request.picture, error);
  if (error)
    throw std::invalid_argument("--picture " + request.picture + ": " + error.message() +
                                "; name a folder that exists or can be made");
}

// On a terminal, overwrites one line; otherwise prints a line every 5 s of simulated time.
class Display {
 public:
  explicit Display(bool quiet) : quiet_{quiet}, terminal_{isatty(STDERR_FILENO) == 1} {}

  void show(const Progress& progress) {
    if (quiet_) return;
    if (terminal_) {
      std::fprintf(stderr, "\r%s ", progress_line(progress).c_str());
    } else if (progress.t >= next_) {
      std::fprintf(stderr, "%s\n", progress_line(progress).c_str());
      next_ = progress.t + 5.0;
    }
  }
  void end() const {
    if (!quiet_ && terminal_) std::fprintf(stderr, "\n");
  }

 private:
  bool quiet_, terminal_;
  double next_ = 0.0;
};

DriveResult drive(const DriveJob& job, const ScenarioRequest& request, Lockstep& lockstep) {
  Display display{request.quiet};
  const auto show = [&](const Progress& progress) { display.show(progress); };
  DriveOptions options = job.options;
  const Scenario scenario = with_options(job.scenario, options);
  options.map.clear();  // already applied to the scenario by with_options
  DriveLog log = options.lockstep ? lockstep.drive(scenario, options, show)
                                  : drive_over_dds(scenario, options, show);
  display.end();
  if (request.picture.empty()) return log.result;
  const auto png = fs::path(request.picture) / (scenario.name + "_" + scenario.method + "_" +
                                                std::to_string(scenario.seed) + ".png");
  draw_drive(scenario, system_of(scenario, options), log, png.string());
  if (!request.quiet) std::printf("picture: %s\n", png.c_str());
  return log.result;
}

std::vector<DriveResult> drive_all(const std::vector<DriveJob>& all,
                                   const ScenarioRequest& request) {
  Lockstep lockstep;                         // each worker process gets its own copy by fork
  if (request.lockstep && all.size() > 1) {  // progress lines of parallel drives would interleave
    ScenarioRequest each = request;
    each.quiet = true;
    ProgressBar bar{all.size(), 0, "drives"};
    auto results = run_side_by_side(
        all, request.jobs, [&](const DriveJob& job) { return drive(job, each, lockstep); },
        [&] {
          if (!request.quiet) bar.step("");
        });
    if (!request.quiet && !request.picture.empty())
      std::printf("%zu pictures: %s\n", all.size(), request.picture.c_str());
    return results;
  }
  if (!request.lockstep) rt::install_signal_handlers();
  std::vector<DriveResult> results;
  for (const DriveJob& job : all) {
    DriveResult result = drive(job, request, lockstep);
    if (!request.lockstep && rt::shutting_down())  // an interrupted drive gives no result
      throw std::runtime_error(
          fmt::format("interrupted after {} of {} drives", results.size(), all.size()));
    results.push_back(std::move(result));
  }
  return results;
}

std::string list_of_methods() {
  std::string lines = "Methods, and what drives the robot:";
  for (const DriveMethod& method : all_methods())
    lines += fmt::format("\n  {:<15}{}", method.name, method.about);
  return lines;
}

int run(const ScenarioRequest& request) {
  if (request.lockstep && request.dds)
    throw std::invalid_argument("--lockstep and --dds exclude each other");
  if (request.jobs > 1 && !request.lockstep)
    throw std::invalid_argument("--jobs needs --lockstep: over DDS one system runs at a time");
  check_outputs(request);
  const auto jobs = jobs_of(request);
  for (const DriveJob& job : jobs)
    if (std::error_code error;
        !request.json.empty() && fs::equivalent(job.scenario.path, request.json, error))
      throw std::invalid_argument("--json " + request.json + ": would overwrite the scenario");
  const auto results = drive_all(jobs, request);
  if (!request.json.empty()) {
    std::ofstream out{request.json};
    out << nlohmann::json(results).dump(2) << '\n';
    if (!out) throw std::runtime_error(request.json + ": cannot be written");
  }
  std::printf("%s", summary_table(results).c_str());
  const bool held = std::all_of(results.begin(), results.end(),
                                [](const auto& result) { return result.failures.empty(); });
  return held ? 0 : 1;
}

}  // namespace

void add_scenario_command(CLI::App& app, int& status) {
  auto* command = app.add_subcommand("scenario", "Drive scenarios and check their expectations");
  auto request = std::make_shared<ScenarioRequest>();
  command
      ->add_option("files", request->files,
                   "scenario files, or names of scenarios that come with Tandem")
      ->required();
  command->add_option(
      "--method", request->method,
      "a method below, or all: each that the scenario lists; default: the scenario's");
  command->add_option(
      "--driver", request->driver,
      "simulated person: navigator, pointer, script, reckless, adversary or replay, each with "
      "optional "
      "modifiers after +, as navigator+tremor: one_sided, over_correction, tremor, quantised, "
      "pulses, dropouts; default: the scenario's");
  command->add_option("--recording", request->recording, "recording for the driver replay")
      ->check(CLI::ExistingPath);
  command->add_option(
      "--recording-topic", request->recording_topic,
      "full name of the recorded joystick topic, as /a/joy; needed if there are several");
  auto* seed = command->add_option("--seed", request->seed,
                                   "seed of the simulated person; default: the scenario's");
  command
      ->add_option("--seeds", request->seeds, "all seeds from A to B, as A-B, or from 1 to N, as N")
      ->excludes(seed);
  command->add_option("--map", request->map,
                      "map instead of the scenario's: a file (OctoMap or YAML), or the name of one "
                      "of Tandem's own");
  command->add_option("--json", request->json, "write all results to this file");
  command->add_option("--picture", request->picture, "write a PNG of each drive into this folder")
      ->take_last();  // overrides the folder that bringup/demo passes first
  command->add_flag("--dds", request->dds, "the real nodes over DDS (default)");
  command->add_flag(
      "--lockstep", request->lockstep,
      "the same nodes on a bus inside the process, deterministic and faster than real time");
  command->add_option("--speed", request->speed,
                      "over DDS: simulated time per real time; default: 1");
  command->add_flag("--no-filter", request->no_filter,
                    "the safety filter does not intervene, which shows the method alone");
  command->add_option("--jobs", request->jobs, "with --lockstep: number of parallel processes")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--quiet", request->quiet, "no progress line");
  command->footer(list_of_methods);
  command->callback([request, &status] { status = run(*request); });
}

}  // namespace tandem
