// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/study_command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "bringup/cli/study_drives.hpp"
#include "bringup/study/study.hpp"
#include "bringup/study/study_folder.hpp"
#include "bringup/study/study_plan.hpp"
#include "bringup/study/study_report.hpp"
#include "bringup/study/study_summary.hpp"
#include "bringup/study/study_worlds.hpp"
#include "bringup/system/shared_files.hpp"

namespace tandem {
namespace {

constexpr std::size_t kMaxListed = 20'000;  // drives

struct StudyRequest {
  std::string study, out, shard, plan;
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
  unsigned shards = 1;
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

// Indices into study.drives of those that the request names.
std::vector<std::size_t> drives_of(const Study& study, const StudyRequest& request) {
  const Shard shard = read_shard(request.shard);
  if (!request.plan.empty()) return drives_of_shard(study, request.plan, shard.index, shard.count);
  std::vector<std::size_t> drives;
  for (std::size_t i = shard.index - 1; i < study.drives.size(); i += shard.count)
    drives.push_back(i);
  return drives;
}

void report_other_builds(const StudyFolder& folder) {
  std::size_t all = 0, others = 0;
  for (const auto& origin : origins_of(folder)) {
    const auto drives = origin.at("drives").get<std::size_t>();
    all += drives;
    if (origin.at("build") != this_origin().build) others += drives;
  }
  if (others > 0)
    std::fprintf(
        stderr,
        "%s: %zu finished drives, %zu of them by another build of tandem, whose results may "
        "differ; for a study by a single build, choose another folder\n",
        folder.path().c_str(), all, others);
}

// JSON and CSV of each drive only for a study that programs can load in one piece.
void list_drives(const StudyFolder& folder) {
  const std::string file = folder.path() + "/drives";
  if (folder.planned() > kMaxListed) {
    std::fprintf(stderr,
                 "%s.json and .csv are not written for more than %zu drives: read %s.sqlite\n",
                 file.c_str(), kMaxListed, file.c_str());
    return;
  }
  write_file(file + ".json", json_of(folder));
  write_file(file + ".csv", csv_of(folder));
}

void write_results(const StudyFolder& folder, bool with_report) {
  list_drives(folder);
  const nlohmann::json summary = summary_of(folder), origins = origins_of(folder);
  write_file(folder.path() + "/origins.json", origins.dump(1) + "\n");
  write_file(folder.path() + "/summary.json", summary.dump(1) + "\n");
  std::printf("%s\n%s", study_table(summary).c_str(), cost_table(folder).c_str());
  std::fflush(stdout);
  if (with_report) draw_report(folder.path());
  const StudyResults& results = folder.results();
  std::set<std::string> builds;
  for (const auto& origin : origins) builds.insert(origin.at("build").get<std::string>());
  std::printf(
      "%zu drives in %s, of %.3g CPU hours%s\n", results.size(), folder.path().c_str(),
      results.cost() / 3600.0,
      builds.size() > 1 ? fmt::format(", by {} builds of tandem", builds.size()).c_str() : "");
}

// The study, with each of its drives constructed once.
Study checked_study(const StudyRequest& request) {
  if (request.study.empty())
    throw std::invalid_argument("study: give a study file, for example bringup/studies/quick.yaml");
  if (request.out.empty()) throw std::invalid_argument("study: --out DIR is missing");
  Study study = load_study(find_file(request.study, "studies"));
  check_study(study);
  return study;
}

void run(const StudyRequest& request) {
  const Shard shard = read_shard(request.shard);
  const Study study = checked_study(request);
  const auto own = drives_of(study, request);
  StudyFolder folder{request.out, contents_of(study)};
  DrivePlan plan = sample_first(unfinished(study, folder, own));
  plan.before = own.size() - plan.todo.size();
  plan.jobs = request.jobs;
  std::fprintf(stderr, "%s: %zu drives%s in %u processes%s\n", study.name.c_str(), own.size(),
               shard.count > 1 ? " of this shard" : "", request.jobs,
               plan.before > 0 ? fmt::format(", {} already finished", plan.before).c_str() : "");
  report_other_builds(folder);
  make_drives(study, folder, plan);
  write_worlds(study, folder);
  write_results(folder, !request.no_report);
}

void merge(const StudyRequest& request) {
  std::vector<nlohmann::json> studies;
  for (const auto& from : request.folders) {
    studies.push_back(read_study(from));
    if (studies.back() != studies.front())
      throw std::invalid_argument(
          from + " and " + request.folders.front() +
          " contain different studies; only shards of one study can be merged");
    studies.resize(1);
  }
  StudyFolder folder{request.merged, studies.front()};
  for (const auto& from : request.folders) {
    const StudyFolder part{from, studies.front()};
    folder.results().add_all_of(part.results());
    merge_worlds(part, folder);
  }
  if (const std::size_t all = folder.planned(), have = folder.results().size(); have < all)
    std::fprintf(stderr, "%zu of %zu drives are missing\n", all - have, all);
  write_results(folder, !request.no_report);
}

void report(const StudyRequest& request) {
  write_results({request.merged, read_study(request.merged)}, true);
}

// Drives a sample into the study's folder, whose drives the shards then leave out.
void plan(const StudyRequest& request) {
  const Study study = checked_study(request);
  StudyFolder folder{request.out, contents_of(study)};
  std::vector<std::size_t> all(study.drives.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto before = unfinished(study, folder, all);
  DrivePlan sample{.todo = sample_of(study, folder, before)};
  sample.jobs = std::max(1U, std::thread::hardware_concurrency());
  std::fprintf(stderr, "%s: measuring the cost on %zu drives\n", study.name.c_str(),
               sample.todo.size());
  make_drives(study, folder, sample);
  write_worlds(study, folder);
  const auto todo = unfinished(study, folder, all);
  const auto shards = std::min<std::size_t>(request.shards, std::max<std::size_t>(1, todo.size()));
  const nlohmann::json planned = plan_of(study, folder, todo, shards);
  write_plan(planned, find_file(request.study, "studies"), request.out);
  double cost = 0.0, most = 0.0;
  for (const auto& shard : planned.at("shards")) {
    cost += shard.at("cost_s").get<double>();
    most = std::max(most, shard.at("cost_s").get<double>());
  }
  std::printf(
      "%zu drives in %zu shards: about %.2g CPU hours on this machine, the longest shard %.1f %% "
      "above the mean\n%s: plan.json, shards.sbatch, merge.sbatch, Snakefile\n",
      todo.size(), shards, cost / 3600.0,
      cost > 0.0 ? 100.0 * (most * static_cast<double>(shards) / cost - 1.0) : 0.0,
      request.out.c_str());
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
  command->add_option("--plan", request->plan,
                      "plan.json of `study plan`, whose shard --shard names");
  command->add_flag("--no-report", request->no_report, "no report.html and no pictures");
  auto* merging = command->add_subcommand("merge", "Merge the shards of a study");
  merging->add_option("out", request->merged, "folder of the results")->required();
  merging->add_option("folders", request->folders, "folders of the shards")
      ->required()
      ->check(CLI::ExistingDirectory);
  merging->add_flag("--no-report", request->no_report, "no report.html and no pictures");
  auto* reporting = command->add_subcommand("report", "Summarize a study's folder and report");
  reporting->add_option("folder", request->merged, "folder of the results")
      ->required()
      ->check(CLI::ExistingDirectory);
  auto* planning = command->add_subcommand(
      "plan", "Divide a study into shards of equal cost, with files for Slurm and Snakemake");
  planning->add_option("study", request->study, "as above")->required();
  planning->add_option("--out", request->out, "folder of plan and results")->required();
  planning->add_option("--jobs", request->shards, "number of shards")
      ->required()
      ->check(CLI::Range(1, 1'000'000));
  command->callback([=] {
    if (merging->parsed())
      merge(*request);
    else if (reporting->parsed())
      report(*request);
    else if (planning->parsed())
      plan(*request);
    else
      run(*request);
  });
}

}  // namespace tandem
