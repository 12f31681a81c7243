// SPDX-License-Identifier: Apache-2.0
// Drives the drives of a study in parallel processes, and prints progress and cost.
#pragma once

#include <vector>

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// Those of the drives `own`, indices into study.drives, that the folder lacks.
[[nodiscard]] std::vector<std::size_t> unfinished(const Study& study, const StudyFolder& folder,
                                                  const std::vector<std::size_t>& own);

/// What to drive, and how.
struct DrivePlan {
  std::vector<std::size_t> todo;  ///< in this order
  std::size_t sample = 0;         ///< the cost of the first so many is printed as all drives' cost
  std::size_t before = 0;         ///< number of drives that were finished earlier
  unsigned jobs = 1;              ///< processes
};

/// Drives and stores each drive as soon as it is finished. Prints the cost of all as soon as the
/// sample is driven, and at the end how many drives a CPU hour made. Throws as work_side_by_side
/// does.
void make_drives(const Study& study, StudyFolder& folder, const DrivePlan& plan);

/// `todo` in the order in which it is driven: a sample that is spread evenly over it, to measure
/// the cost on, then the rest, shuffled: the remaining drives then take about as long as the
/// finished ones, so the displayed time left is realistic.
[[nodiscard]] DrivePlan sample_first(const std::vector<std::size_t>& todo);

}  // namespace tandem
