// SPDX-License-Identifier: Apache-2.0
// Type hashes and type descriptions by name. ROS 2 compares the hashes to detect peers whose
// definition of a type differs.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tandem::runtime {

/// RIHS01 hash (REP-2016) of a type, as "RIHS01_<64 hex digits>". `dds_type` is the name on the
/// wire, "geometry_msgs::msg::dds_::Twist_". Empty for a type that neither Tandem nor
/// tandem_add_interfaces() of a loaded module defines. Thread-safe, as described_type() is.
[[nodiscard]] std::string_view type_hash(std::string_view dds_type);

/// A field in the form of type_description_interfaces/msg/Field.
struct DescribedField {
  std::string_view name;
  std::uint8_t type_id;
  std::uint64_t capacity, string_capacity;
  std::string_view nested;         ///< "builtin_interfaces/msg/Time", or "" for a basic type
  std::string_view default_value;  ///< as it stands in a .msg file; hashes leave it out
};

/// A constant of a type. Descriptions and hashes leave constants out; definitions have them.
struct DescribedConstant {
  std::string_view name;
  std::uint8_t type_id;    ///< that of a field of its type
  std::string_view value;  ///< as it stands in a .msg file
};

struct DescribedType {
  std::string_view name;  ///< "geometry_msgs/msg/Twist"
  std::string_view hash;
  std::span<const DescribedField> fields;
  std::span<const DescribedConstant> constants = {};
};

/// Null for a type without a description, as type_hash(). `name`: "geometry_msgs/msg/Twist".
[[nodiscard]] const DescribedType* described_type(std::string_view name);

/// Called by generated code when a program or module is loaded. `added` must live as long as the
/// process. Of two types of the same name the first counts. Returns true.
bool add_described_types(std::span<const DescribedType> added);

}  // namespace tandem::runtime
