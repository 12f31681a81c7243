// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/study_command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <stdexcept>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "bringup/cli/progress_bar.hpp"
#include "bringup/drive/parallel_drives.hpp"
#include "bringup/study/study.hpp"
#include "bringup/study/study_folder.hpp"
#include "bringup/study/study_report.hpp"
#include "bringup/study/study_summary.hpp"
#include "bringup/study/study_worlds.hpp"
#include "bringup/system/shared_files.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

struct StudyRequest {
  std::string study, out, shard;
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
  bool no_report = false;
  std::string merged;
  std::vector<std::string> folders;
};

struct Shard {
  std::size_t index = 1, count = 1;
};

Shard read_shard(const std::string& text) {
  if (text.empty()) return {};
  Shard shard;
  char rest = '\0';
  if (std::sscanf(text.c_str(), "%zu/%zu%c", &shard.index, &shard.count, &rest) != 2 ||
      shard.index < 1 || shard.index > shard.count || shard.count > 1000000)
    throw std::invalid_argument("--shard " + text + ": expected i/n with 1 <= i <= n, as 2/8");
  return shard;
}

// The unfinished drives of this shard, shuffled: the remaining drives then take about as long as
// the finished ones, so the displayed time left is realistic.
std::vector<std::size_t> missing(const Study& study, const StudyFolder& folder, Shard shard) {
  std::vector<std::size_t> missing;
  for (std::size_t i = shard.index - 1; i < study.drives.size(); i += shard.count)
    if (!folder.finished().contains(name_of(study, study.drives[i]))) missing.push_back(i);
  std::shuffle(missing.begin(), missing.end(), std::mt19937{1});
  return missing;
}

void make_drives(const Study& study, StudyFolder& folder, const StudyRequest& request) {
  const Shard shard = read_shard(request.shard);
  const auto todo = missing(study, folder, shard);
  const std::size_t all = (study.drives.size() + shard.count - shard.index) / shard.count;
  std::fprintf(
      stderr, "%s: %zu drives%s in %u processes%s\n", study.name.c_str(), all,
      shard.count > 1 ? " of this shard" : "", request.jobs,
      todo.size() < all ? fmt::format(", {} already finished", all - todo.size()).c_str() : "");
  const auto builds = folder.builds();
  const std::size_t others =
      folder.finished().size() - (builds.contains(this_build()) ? builds.at(this_build()) : 0);
  if (others > 0)
    std::fprintf(
        stderr,
        "%s: %zu finished drives, %zu of them by another build of tandem, whose results may "
        "differ; for a study by a single build, choose another folder\n",
        folder.path().c_str(), folder.finished().size(), others);
  Lockstep lockstep;  // each worker process gets its own copy by fork
  ProgressBar bar{all, all - todo.size(), "drives"};
  long collisions = 0;
  work_side_by_side(
      todo.size(), request.jobs,
      [&](std::size_t i) {
        const StudyDrive& drive = study.drives[todo[i]];
        try {
          return make_drive(study, drive, lockstep);
        } catch (const std::exception& error) {
          throw std::runtime_error(name_of(study, drive) + ": " + error.what());
        }
      },
      [&](std::size_t i, const nlohmann::json& line) {
        folder.append(name_of(study, study.drives[todo[i]]), line);
        collisions += line.at("drive").get<DriveResult>().collisions;
        bar.step(fmt::format("{} collisions", collisions));
      });
}

void write_results(const StudyFolder& folder, const StudyRequest& request) {
  const auto drives = folder.results();
  const auto groups = groups_of(drives);
  const auto file = [&](const char* name) { return folder.path() + "/" + name; };
  write_file(file("drives.json"), nlohmann::json(drives).dump(1) + "\n");
  write_file(file("drives.csv"), csv_of(drives));
  const auto builds = folder.builds();
  write_file(file("builds.json"), nlohmann::json(builds).dump(1) + "\n");
  write_file(file("summary.json"), summary_of(groups).dump(1) + "\n");
  std::printf("%s\n%s", study_table(groups).c_str(), cost_table(drives).c_str());
  std::fflush(stdout);
  if (!request.no_report) draw_report(folder.path());
  std::printf(
      "%zu drives in %s%s\n", drives.size(), folder.path().c_str(),
      builds.size() > 1 ? fmt::format(", by {} builds of tandem", builds.size()).c_str() : "");
}

void run(const StudyRequest& request) {
  if (request.study.empty())
    throw std::invalid_argument("study: give a study file, for example bringup/studies/quick.yaml");
  if (request.out.empty()) throw std::invalid_argument("study: --out DIR is missing");
  (void)read_shard(request.shard);
  const Study study = load_study(find_file(request.study, "studies"));
  check_study(study);
  StudyFolder folder{request.out, contents_of(study)};
  make_drives(study, folder, request);
  write_worlds(study, folder);
  write_results(folder, request);
}

void merge(const StudyRequest& request) {
  std::vector<nlohmann::json> studies;
  for (const auto& from : request.folders) {
    studies.push_back(read_study(from));
    if (studies.back() != studies.front())
      throw std::invalid_argument(
          from + " and " + request.folders.front() +
          " contain different studies; only shards of one study can be merged");
  }
  StudyFolder folder{request.merged, studies.front()};
  for (const auto& from : request.folders) {
    const StudyFolder part{from, studies.front()};
    for (const auto& [name, line] : part.finished())
      if (!folder.finished().contains(name)) folder.append(name, line);
    merge_worlds(part, folder);
  }
  const std::size_t all = studies.front().at("drives").size();
  if (folder.finished().size() < all)
    std::fprintf(stderr, "%zu of %zu drives are missing\n", all - folder.finished().size(), all);
  write_results(folder, request);
}

}  // namespace

void add_study_command(CLI::App& app) {
  auto request = std::make_shared<StudyRequest>();
  auto* command = app.add_subcommand(
      "study", "Drive scenarios × methods × drivers × seeds, and report; resumes where it stopped");
  command->add_option("study", request->study,
                      "study file, or name of a study that comes with Tandem");
  command->add_option("--out", request->out, "folder of the results");
  command->add_option("--jobs", request->jobs, "number of parallel processes")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--shard", request->shard,
                      "i/n: only every n-th drive, beginning with the i-th");
  command->add_flag("--no-report", request->no_report, "JSON and CSV only");
  auto* merging = command->add_subcommand("merge", "Merge the shards of a study");
  merging->add_option("out", request->merged, "folder of the results")->required();
  merging->add_option("folders", request->folders, "folders of the shards")
      ->required()
      ->check(CLI::ExistingDirectory);
  merging->add_flag("--no-report", request->no_report, "JSON and CSV only");
  command->callback([=] {
    if (merging->parsed())
      merge(*request);
    else
      run(*request);
  });
}

}  // namespace tandem
