// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: what the bytes of a message type can be, before they are decoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace tandem::runtime {

/// The fields of a type of idl/*.idl, as plain CDR (XCDR1) lays them out.
class CdrStructure {
 public:
  /// Null for a type that is not ours. "geometry_msgs/msg/Twist"; made once per name.
  [[nodiscard]] static const CdrStructure* of(std::string_view type);

  /// Whether all that the fields claim is there: no text or sequence has more elements than bytes
  /// that could hold them. `bytes` begin with the encapsulation. Decoding what passes makes room
  /// for no more elements than there are.
  [[nodiscard]] bool fits(std::span<const std::uint8_t> bytes) const;

  /// [bytes] of the largest message, encapsulation included; nothing if it has no bound.
  [[nodiscard]] std::optional<std::size_t> largest() const;

  struct Field {
    enum class Of { kPrimitives, kTexts, kStructures };
    enum class Many { kOne, kArray, kSequence };
    Of of;
    Many many;
    std::size_t size;               ///< of a primitive [bytes]
    std::size_t count;              ///< of an array
    const CdrStructure* structure;  ///< of its elements
  };

 private:
  explicit CdrStructure(std::string_view type);
  [[nodiscard]] static std::size_t least(const Field& field);  // [bytes] of an element

  std::vector<Field> fields_;
  std::size_t least_ = 0;  // [bytes] that one takes, padding left out
  std::size_t most_ = 0;   // with padding before each number; of bounded ones
  bool bounded_ = true;

  friend class CdrWalk;
};

}  // namespace tandem::runtime
