// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_plan.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/study/shell_quoted.hpp"
#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMaxSample = 100, kSampleShare = 20;

// Mean costs of finished drives.
class MeanCosts {
 public:
  explicit MeanCosts(const StudyResults& results) {
    results.query("SELECT scenario, method, driver, avg(cost_s) FROM drives GROUP BY 1, 2, 3", {},
                  [&](const SqliteStatement& row) {
                    of_group_[{sql::text(row, 0), sql::text(row, 1), sql::text(row, 2)}] =
                        sqlite3_column_double(row.get(), 3);
                  });
    results.query("SELECT method, avg(cost_s) FROM drives GROUP BY 1", {},
                  [&](const SqliteStatement& row) {
                    of_method_[sql::text(row, 0)] = sqlite3_column_double(row.get(), 1);
                  });
    overall_ = results.cost() / static_cast<double>(std::max<std::size_t>(1, results.size()));
  }

  [[nodiscard]] double of(const DriveGroup& group) const {
    if (const auto own = of_group_.find(group); own != of_group_.end()) return own->second;
    const auto like = of_method_.find(group.method);
    return like != of_method_.end() ? like->second : overall_;
  }

 private:
  std::map<DriveGroup, double> of_group_;
  std::map<std::string, double> of_method_;
  double overall_ = 0.0;
};

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw std::invalid_argument(file + ": " + why);
}

json read_plan(const std::string& file) {
  std::ifstream in{file};
  if (!in) refuse(file, "no such file; write it with `tandem study plan`");
  json plan = parse_json_or_null(in);
  if (plan.is_object() && plan.contains("description") && plan.contains("shards") &&
      plan["shards"].is_array())
    return plan;
  refuse(file, "is not a plan of `tandem study plan`; write it again");
}

// The seeds of each group in a shard.
std::map<std::string, std::set<unsigned>> seeds_of(const json& shard, const std::string& file) {
  std::map<std::string, std::set<unsigned>> seeds;
  try {
    for (const auto& [group, text] : shard.at("drives").items()) {
      const auto all = seeds_in(text.get<std::string>());
      seeds[group] = {all.begin(), all.end()};
    }
  } catch (const std::exception& error) {
    refuse(file, std::string{"is damaged: "} + error.what() + "; write it again");
  }
  return seeds;
}

// What the files for Slurm and Snakemake are filled in with.
struct Cluster {
  std::string name, tandem, study, folder;
  std::size_t shards;
  long minutes;
};

// A job name without characters that need quotes.
std::string plain(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

// Node failures make Slurm requeue a shard. After an error the script does, twice, because Slurm
// does not.
std::string slurm_shards(const Cluster& c) {
  return fmt::format(
      R"(#!/bin/bash
# Drives the {shards} shards of {name}. Written by `tandem study plan`. A shard that is started
# again continues where it stopped, so that this file may be submitted again at any time.
#SBATCH --job-name=tandem_{name}
#SBATCH --array=1-{shards}
#SBATCH --time={minutes}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output="{folder}/logs/shard_%a.log"
tandem={tandem}
study={study}
folder={folder_quoted}
shard=$SLURM_ARRAY_TASK_ID
"$tandem" study "$study" --plan "$folder/plan.json" --shard "$shard/{shards}" --out "$folder/shards/$shard" \
  --jobs "${{SLURM_CPUS_PER_TASK:-1}}" --no-report && exit
[ "${{SLURM_RESTART_COUNT:-0}}" -lt 2 ] || exit 1
scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$shard" && sleep 60 # until the requeue ends it
)",
      fmt::arg("name", plain(c.name)), fmt::arg("shards", c.shards), fmt::arg("minutes", c.minutes),
      fmt::arg("folder", c.folder), fmt::arg("tandem", shell_quoted(c.tandem)),
      fmt::arg("study", shell_quoted(c.study)), fmt::arg("folder_quoted", shell_quoted(c.folder)));
}

std::string slurm_merge(const Cluster& c) {
  return fmt::format(R"(#!/bin/bash
# Merges the shards of {name} and draws the report. Written by `tandem study plan`.
#SBATCH --job-name=tandem_{name}_merge
#SBATCH --time={minutes}
#SBATCH --ntasks=1
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --kill-on-invalid-dep=yes
#SBATCH --output="{folder}/logs/merge.log"
folder={folder_quoted}
{tandem} study merge "$folder" "$folder"/shards/*
)",
                     fmt::arg("name", plain(c.name)), fmt::arg("minutes", c.minutes),
                     fmt::arg("folder", c.folder), fmt::arg("tandem", shell_quoted(c.tandem)),
                     fmt::arg("folder_quoted", shell_quoted(c.folder)));
}

// Snakemake removes the declared outputs of a rule that fails. Those of a shard are therefore not
// its results, which are kept and continued.
std::string snakefile(const Cluster& c) {
  return fmt::format(R"(# Drives the {shards} shards of {name}, merges them and draws the report.
# Written by `tandem study plan`.
TANDEM = {tandem}
STUDY = {study}
SHARDS = {shards}

workdir: {folder}

rule all:
    input: "report.html"

rule shard:
    input: "plan.json"
    output: touch("logs/shard_{{i}}.done")
    log: "logs/shard_{{i}}.log"
    threads: 1
    resources: runtime={minutes}
    retries: 2
    shell:
        "{{TANDEM:q}} study {{STUDY:q}} --plan plan.json --shard {{wildcards.i}}/{{SHARDS}}"
        " --out shards/{{wildcards.i}} --jobs {{threads}} --no-report >> {{log}} 2>&1"

rule merge:
    input: expand("logs/shard_{{i}}.done", i=range(1, SHARDS + 1))
    output: "summary.json"
    log: "logs/merge.log"
    resources: runtime={minutes}
    shell: "{{TANDEM:q}} study merge . shards/* --no-report > {{log}} 2>&1"

rule report:
    input: "summary.json"
    output: "report.html"
    log: "logs/report.log"
    shell: "{{TANDEM:q}} study report . > {{log}} 2>&1"
)",
                     fmt::arg("name", plain(c.name)), fmt::arg("shards", c.shards),
                     fmt::arg("minutes", c.minutes), fmt::arg("tandem", json(c.tandem).dump()),
                     fmt::arg("study", json(c.study).dump()),
                     fmt::arg("folder", json(c.folder).dump()));
}

}  // namespace

std::vector<std::size_t> sample_of(const Study& study, const StudyFolder& folder,
                                   const std::vector<std::size_t>& todo) {
  std::set<DriveGroup> known;
  folder.results().query("SELECT DISTINCT scenario, method, driver FROM drives", {},
                         [&](const SqliteStatement& row) {
                           known.insert({sql::text(row, 0), sql::text(row, 1), sql::text(row, 2)});
                         });
  std::set<std::size_t> sample;
  for (const std::size_t i : todo)
    if (known.insert(group_of(study, study.drives[i])).second) sample.insert(i);
  const std::size_t wanted = std::min(kMaxSample, study.drives.size() / kSampleShare);
  const std::size_t finished = study.drives.size() - todo.size();
  for (std::size_t k = 0; k < wanted && finished + sample.size() < wanted; ++k)
    sample.insert(todo[k * todo.size() / wanted]);
  return {sample.begin(), sample.end()};
}

std::vector<std::size_t> balanced(const std::vector<double>& costs, std::size_t shards) {
  std::vector<std::size_t> order(costs.size()), shard_of(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  using Load = std::pair<double, std::size_t>;  // cost so far, shard
  std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
  for (std::size_t shard = 0; shard < shards; ++shard) loads.emplace(0.0, shard);
  for (const std::size_t i : order) {
    const auto [load, shard] = loads.top();
    loads.pop();
    shard_of[i] = shard;
    loads.emplace(load + costs[i], shard);
  }
  return shard_of;
}

json plan_of(const Study& study, const StudyFolder& folder, const std::vector<std::size_t>& todo,
             std::size_t shards) {
  const MeanCosts means{folder.results()};
  std::vector<double> costs;
  for (const std::size_t i : todo) costs.push_back(means.of(group_of(study, study.drives[i])));
  const auto shard_of = balanced(costs, shards);
  std::vector<double> cost(shards, 0.0);
  std::vector<std::map<std::string, std::vector<unsigned>>> drives(shards);
  for (std::size_t k = 0; k < todo.size(); ++k) {
    const StudyDrive& drive = study.drives[todo[k]];
    cost[shard_of[k]] += costs[k];
    drives[shard_of[k]][name_of(group_of(study, drive))].push_back(drive.seed);
  }
  json all = json::array();
  for (std::size_t shard = 0; shard < shards; ++shard) {
    json seeds = json::object();
    for (auto& [group, own] : drives[shard]) {
      std::sort(own.begin(), own.end());
      seeds[group] = seed_ranges(own);
    }
    all.push_back({{"cost_s", cost[shard]}, {"drives", seeds}});
  }
  return {{"study", study.name},
          {"description", study.description},
          {"machine", this_origin().machine},
          {"shards", all}};
}

std::vector<std::size_t> drives_of_shard(const Study& study, const std::string& file, std::size_t i,
                                         std::size_t n) {
  const json plan = read_plan(file);
  if (plan["description"] != study.description)
    refuse(file, fmt::format("is the plan of another study ({} differs); write it again",
                             first_difference(plan["description"], study.description)));
  if (plan["shards"].size() != n)
    refuse(file, fmt::format("has {0} shards, not {1}; name one of them: --shard 1/{0}",
                             plan["shards"].size(), n));
  const auto seeds = seeds_of(plan["shards"][i - 1], file);
  std::vector<std::size_t> drives;
  for (std::size_t k = 0; k < study.drives.size(); ++k) {
    const auto own = seeds.find(name_of(group_of(study, study.drives[k])));
    if (own != seeds.end() && own->second.contains(study.drives[k].seed)) drives.push_back(k);
  }
  return drives;
}

long time_limit(const json& plan) {
  double most = 0.0;
  for (const json& shard : plan.at("shards"))
    most = std::max(most, shard.at("cost_s").get<double>());
  return static_cast<long>(3.0 * most / 60.0) + 10;
}

void write_plan(const json& plan, const std::string& study, const std::string& folder) {
  const Cluster cluster{.name = plan.at("study"),
                        .tandem = fs::read_symlink("/proc/self/exe"),
                        .study = fs::absolute(study).lexically_normal(),
                        .folder = fs::canonical(folder),
                        .shards = plan.at("shards").size(),
                        .minutes = time_limit(plan)};
  fs::create_directories(fs::path(folder) / "logs");
  write_file(folder + "/plan.json", plan.dump(1) + "\n");
  write_file(folder + "/shards.sbatch", slurm_shards(cluster));
  write_file(folder + "/merge.sbatch", slurm_merge(cluster));
  write_file(folder + "/Snakefile", snakefile(cluster));
}

}  // namespace tandem
