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
  std::uint32_t owner_size = sizeof "Tandem";  ///< [bytes], as the next
  std::uint32_t content_size = kContentSize;   ///< of what follows `owner`
  std::uint32_t type = kType;                  ///< of the note
  char owner[8] = "Tandem";                    ///< whose notes these are
  char abi[16] = TANDEM_ABI_VERSION;           ///< the Tandem that it was built for
  char component[kMaxModuleName + 1] = "";     ///< that the module has
  char package[kMaxModuleName + 1] = "";       ///< empty: the component's name

  static constexpr std::uint32_t kContentSize = 16 + 2 * (kMaxModuleName + 1);  ///< [bytes]
  static constexpr std::uint32_t kType = 1;  ///< this kind of note
};

}  // namespace tandem::runtime
