// SPDX-License-Identifier: Apache-2.0
// Drives the drives of a study in parallel processes, and prints progress and cost.
#pragma once

#include <vector>

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// Those of the drives `own`, indices into study.drives, that the folder lacks.
[[nodiscard]] std::vector<std::size_t> unfinished(const Study& study, const StudyFolder& folder,
                                                  const std::vector<std::size_t>& own);

/// Drives `todo` in that order and stores each drive as soon as it is finished. `before`: number of
/// drives that were finished earlier. As soon as the first `sample` are driven, prints what all
/// will cost; at the end, how many it drove per CPU hour. Throws as work_side_by_side does.
struct DrivePlan {
  std::vector<std::size_t> todo;
  std::size_t sample = 0, before = 0;
  unsigned jobs = 1;
};
void make_drives(const Study& study, StudyFolder& folder, const DrivePlan& plan);

/// `todo` in the order in which it is driven: a sample that is spread evenly over it, to measure
/// the cost on, then the rest, shuffled: the remaining drives then take about as long as the
/// finished ones, so the displayed time left is realistic.
[[nodiscard]] DrivePlan sample_first(const std::vector<std::size_t>& todo);

}  // namespace tandem
