// SPDX-License-Identifier: Apache-2.0
// Reads one YAML document of bounded size from text or a file. All YAML input passes through here.
#pragma once

#include <string>

#include <yaml-cpp/yaml.h>

namespace tandem {

/// The one document of `text`; a null node if there is none. Throws YAML::Exception, with the
/// position, for text that is not YAML or is longer than 16 MiB, for a second document, which would
/// be ignored, and for content nested deeper than 64 levels or with more than 10⁶ values: aliases
/// can make a short text an infinite tree, or one that exhausts memory.
[[nodiscard]] YAML::Node parse_document(const std::string& text);

/// The one document of a file. Throws std::invalid_argument "FILE:LINE: what is wrong", or "FILE:
/// …" if the file is missing, is a folder, or cannot be read.
[[nodiscard]] YAML::Node load_document(const std::string& file);

/// "FILE:LINE: what is wrong", on one line whatever the file contains.
[[nodiscard]] std::string describe(const std::string& file, const YAML::Exception& error);

/// A parameter value as YAML text on one line; keeps quotes, unlike YAML::Dump.
[[nodiscard]] std::string yaml_text(const YAML::Node& value);

}  // namespace tandem
