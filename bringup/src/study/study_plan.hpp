// SPDX-License-Identifier: Apache-2.0
// Divides the drives of a study into shards of equal cost, and writes the files with which Slurm
// and Snakemake drive them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// Those of the unfinished drives `todo` (indices into study.drives) that are still needed to know
/// what the others cost: the first of each group of which no drive is finished, and as many, evenly
/// spread, that a twentieth of the study is known, or 100 drives.
[[nodiscard]] std::vector<std::size_t> sample_of(const Study& study, const StudyFolder& folder,
                                                 const std::vector<std::size_t>& todo);

/// Assigns each drive to the shard that has the least cost so far, the most expensive drives first.
/// The result is the shard of each.
[[nodiscard]] std::vector<std::size_t> balanced(const std::vector<double>& costs,
                                                std::size_t shards);

/// The manifest of the drives `todo`: {"study", "description", "machine", "shards": [{"cost_s": c,
/// "drives": {GROUP: "1-3,7"}}, …]}. A drive's cost is the mean of the finished drives of its group
/// in `folder`, which must have finished drives; of its method if its group has none.
[[nodiscard]] nlohmann::json plan_of(const Study& study, const StudyFolder& folder,
                                     const std::vector<std::size_t>& todo, std::size_t shards);

/// Reads a manifest and returns the drives of its shard i of n, as indices into study.drives.
/// Throws std::invalid_argument or std::runtime_error, which name the file, if it is not a plan of
/// this study with n shards.
[[nodiscard]] std::vector<std::size_t> drives_of_shard(const Study& study, const std::string& file,
                                                       std::size_t i, std::size_t n);

/// The time that a shard is given [min]: three times the cost of the most expensive one, because
/// other machines are slower, and ten minutes.
[[nodiscard]] long time_limit(const nlohmann::json& plan);

/// Writes plan.json, shards.sbatch, merge.sbatch and Snakefile into `folder`, and makes the folder
/// of their logs. `study`: the study's file.
void write_plan(const nlohmann::json& plan, const std::string& study, const std::string& folder);

}  // namespace tandem
