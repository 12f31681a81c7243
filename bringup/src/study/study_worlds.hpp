// SPDX-License-Identifier: Apache-2.0
// Writes the worlds of a study to its folder's worlds.json, from which the report draws them.
#pragma once

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// Writes start, goal, outline and obstacle cells of the first four worlds of each scenario with
/// finished drives, in M [m, rad]; the outline's convex parts in B [m]:
///
///   {SCENARIO: {"start": [x, y, heading], "outline": [PART, …], "goal": {"region": [x1, y1, x2,
///    y2]} or {"pose": [x, y, heading], "tolerance": r} or {"poses": [[x, y, heading], …],
///    "tolerance": r} or {}, "worlds": {MAP'S FILE NAME: {"resolution": r, "cells": [[x, y],
///    …]}}}}, PART: [[x, y], …]
///
/// Throws std::runtime_error naming worlds.json if it is damaged or cannot be written.
void write_worlds(const Study& study, const StudyFolder& folder);

/// Adds the worlds of one folder to those of another, up to four per scenario. Throws like
/// write_worlds.
void merge_worlds(const StudyFolder& from, const StudyFolder& into);

}  // namespace tandem
