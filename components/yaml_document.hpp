// SPDX-License-Identifier: Apache-2.0
// In: YAML from anywhere. Out: its one document, which can be walked through.
#pragma once

#include <cstddef>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace tandem {

/// What YAML::LoadAll found, as one document; a null one if there is none. Throws YAML::Exception
/// with the place for a second document, which nobody would read, and for what is nested deeper
/// than 64 or has more than 10⁶ values: aliases can make a short text a tree without end, or one
/// that outgrows the memory.
inline YAML::Node one_document(const std::vector<YAML::Node>& documents) {
  if (documents.empty()) return {};
  for (std::size_t i = 1; i < documents.size(); ++i)
    if (!documents[i].IsNull())
      throw YAML::Exception(documents[i].Mark(),
                            "a second document begins here and would not be read; bring both "
                            "together and take out the `---` between them");
  constexpr int kDeepest = 64;
  constexpr std::size_t kMost = 1'000'000;
  std::size_t values = 0;
  const auto walk = [&](const auto& self, const YAML::Node& node, int depth) -> void {
    if (depth > kDeepest)
      throw YAML::Exception(node.Mark(), "nested too deep; is there an alias within its anchor?");
    if (++values > kMost)
      throw YAML::Exception(node.Mark(),
                            "more than a million values; are there aliases of aliases?");
    if (node.IsSequence())
      for (const auto& element : node) self(self, element, depth + 1);
    if (node.IsMap())
      for (const auto& entry : node) {
        self(self, entry.first, depth + 1);
        self(self, entry.second, depth + 1);
      }
  };
  walk(walk, documents.front(), 0);
  return documents.front();
}

}  // namespace tandem
