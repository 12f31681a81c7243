// SPDX-License-Identifier: Apache-2.0
// The size of a mesh in an STL file.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

namespace tandem {

/// The bounding box of all vertices of an STL file, binary or text, in the file's own unit. Throws
/// std::runtime_error, without the file's name, if it cannot be read, is cut off or has no
/// vertices.
[[nodiscard]] Eigen::AlignedBox3d stl_bounding_box(const std::filesystem::path& file);

}  // namespace tandem
