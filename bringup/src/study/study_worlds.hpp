// SPDX-License-Identifier: Apache-2.0
// In: a study and its folder. Out: the folder's worlds.json, for those who draw.
#pragma once

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// Writes start, goal, outline and the obstacle cells of the worlds that were driven, the first few
/// of each scenario:
///
///   {SCENARIO: {"start": [x, y, heading], "outline": [PART, …], "goal": {"region": [x1, y1, x2,
///    y2]} or {"pose": [x, y, heading], "tolerance": r} or {}, "worlds": {MAP'S FILE NAME:
///    {"resolution": r, "cells": [[x, y], …]}}}}, PART: [[x, y], …]
void write_worlds(const Study& study, const StudyFolder& folder);

/// Adds the worlds of one folder to those of another.
void merge_worlds(const StudyFolder& from, const StudyFolder& into);

}  // namespace tandem
