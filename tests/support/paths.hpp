// SPDX-License-Identifier: Apache-2.0
// Locates files of the checkout and of the build for tests.
#pragma once

#include <string>
#include <vector>

namespace tandem::test {

/// Absolute path of `file` in the checkout ("maps/forest.bt"), or of the checkout itself if empty.
[[nodiscard]] std::string source_path(const std::string& file = {});

/// Absolute paths of the YAML files in `folder` of the checkout whose names begin with `prefix`,
/// sorted.
[[nodiscard]] std::vector<std::string> yaml_files(const std::string& folder,
                                                  const std::string& prefix = {});

/// The same in the build folder.
[[nodiscard]] std::string binary_path(const std::string& file = {});

/// The same for the folder of real maps and byte vectors, which may be missing.
[[nodiscard]] std::string shared_path(const std::string& file = {});

/// The same for the folder of interop peers, which tests/interop/build_peers fills.
[[nodiscard]] std::string peers_path(const std::string& file = {});

}  // namespace tandem::test
