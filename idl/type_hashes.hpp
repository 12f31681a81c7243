// SPDX-License-Identifier: Apache-2.0
// In: the name of a type. Out: the hash by which ROS 2 tells whether two mean the same by it, and
// the description that is hashed.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tandem::runtime {

/// RIHS01 hash (REP-2016) of a structure of idl/*.idl, as "RIHS01_<64 hex digits>". `dds_type` is
/// as on the wire, "geometry_msgs::msg::dds_::Twist_". Empty for a type that is not ours.
[[nodiscard]] std::string_view type_hash(std::string_view dds_type);

/// A field as type_description_interfaces/msg/Field describes it (its default is not known here).
struct DescribedField {
  std::string_view name;
  std::uint8_t type_id;
  std::uint64_t capacity, string_capacity;
  std::string_view nested;  ///< type of the field, or "": "builtin_interfaces/msg/Time"
};

struct DescribedType {
  std::string_view name;  ///< "geometry_msgs/msg/Twist"
  std::string_view hash;
  std::span<const DescribedField> fields;
};

/// Null for a type that is not ours.
[[nodiscard]] const DescribedType* described_type(std::string_view name);

}  // namespace tandem::runtime
