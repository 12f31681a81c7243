// SPDX-License-Identifier: Apache-2.0
// The only place where YAML text enters. In: text or a file. Out: its one document, of bounded
// size.
#pragma once

#include <string>

#include <yaml-cpp/yaml.h>

namespace tandem {

/// The one document of `text`; a null node if there is none. Throws YAML::Exception, with the
/// place, for text that is no YAML or is longer than 16 MiB, for a second document, which would not
/// be read, and for what is nested deeper than 64 levels or holds more than 10⁶ values: aliases can
/// make a short text a tree without end, or one that outgrows the memory.
[[nodiscard]] YAML::Node parse_document(const std::string& text);

/// The one document of a file. Throws std::invalid_argument "FILE:LINE: what is wrong", or
/// "FILE: …" for a file that is missing, a folder, or cannot be read.
[[nodiscard]] YAML::Node load_document(const std::string& file);

/// "FILE:LINE: what is wrong", in one line whatever the file holds.
[[nodiscard]] std::string describe(const std::string& file, const YAML::Exception& error);

/// A value as YAML text in one line, for a parameter; unlike YAML::Dump it keeps quotes.
[[nodiscard]] std::string yaml_text(const YAML::Node& value);

}  // namespace tandem
