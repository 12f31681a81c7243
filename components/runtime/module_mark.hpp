// SPDX-License-Identifier: Apache-2.0
// Marks a module with what must be known before its code runs: the Tandem that it was built for.
#pragma once

#include <cstdint>

#include <tandem/version.hpp>

namespace tandem::runtime {

/// Names of components and packages have at most this many characters.
inline constexpr int kMaxModuleName = 63;

/// An ELF note (elf(5)), which TANDEM_COMPONENT puts into a module's file. The owner, the type and
/// the place of `abi` are the same in every version.
struct ModuleMark {
  std::uint32_t owner_size = sizeof "Tandem", content_size = kContentSize, type = kType;
  char owner[8] = "Tandem";
  char abi[16] = TANDEM_ABI_VERSION;
  char component[kMaxModuleName + 1] = "";
  char package[kMaxModuleName + 1] = "";  ///< empty: the component's name

  static constexpr std::uint32_t kContentSize = 16 + 2 * (kMaxModuleName + 1), kType = 1;
};

}  // namespace tandem::runtime
