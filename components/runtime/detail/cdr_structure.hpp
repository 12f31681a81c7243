// SPDX-License-Identifier: Apache-2.0
// Checks the serialized bytes of a message against its type before they are decoded. Private to
// runtime/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// The plain CDR (XCDR1) layout of a type from idl/*.idl.
class TANDEM_EXPORT_FOR_TESTS CdrStructure {
 public:
  /// The layout of a type such as "geometry_msgs/msg/Twist", cached by name. Null for a type that
  /// is not in idl/.
  [[nodiscard]] static const CdrStructure* of(std::string_view type);

  /// Whether every string and sequence has no more elements than the remaining bytes can hold, so
  /// that decoding cannot over-allocate. `bytes` begin with the encapsulation header.
  [[nodiscard]] bool fits(std::span<const std::uint8_t> bytes) const;

  /// Appends a message to `out`, aligned for that place and in little-endian order, as a nested
  /// structure or an element of a sequence is. Both begin with the encapsulation header; that of
  /// `message` is left out. Returns false for bytes that do not fit; `out` is then of no use.
  [[nodiscard]] bool append(std::span<const std::uint8_t> message,
                            std::vector<std::uint8_t>& out) const;

  /// Maximum serialized size including encapsulation [bytes]; nullopt if unbounded.
  [[nodiscard]] std::optional<std::size_t> largest() const;

  struct Field {
    enum class Of { kPrimitives, kTexts, kStructures };
    enum class Many { kOne, kArray, kSequence };
    Of of;
    Many many;
    std::size_t size;               ///< [bytes] of one primitive
    std::size_t count;              ///< elements of an array, otherwise 1
    const CdrStructure* structure;  ///< layout of nested structures, otherwise null
  };

 private:
  explicit CdrStructure(std::string_view type);
  [[nodiscard]] static std::size_t least(const Field& field);  // minimum size of an element [bytes]

  std::vector<Field> fields_;
  std::size_t least_ = 0;  // minimum size without padding [bytes]
  std::size_t most_ = 0;   // maximum size with padding [bytes], if bounded_
  bool bounded_ = true;

  friend class CdrWalk;
};

}  // namespace tandem::runtime
