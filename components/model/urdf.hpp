// SPDX-License-Identifier: Apache-2.0
// Describes a robot's shape as URDF.
#pragma once

#include <string>

#include "tandem/model/robot.hpp"

namespace tandem {

/// A URDF document with one link, `base_frame`, so that no other transforms are needed. It shows
/// the outline (a rectangle as a box, polygons by their edges) and two wheels; heights and the
/// wheels' size are not known and only drawn. Throws std::invalid_argument as footprint_of().
[[nodiscard]] std::string urdf_of(const RobotParams& robot, const std::string& base_frame);

}  // namespace tandem
