// SPDX-License-Identifier: Apache-2.0
// In: the DDS name of a type. Out: the hash by which ROS 2 tells whether two mean the same by it.
#pragma once

#include <string_view>

namespace tandem::runtime {

/// RIHS01 hash (REP-2016) of a structure of idl/*.idl, as "RIHS01_<64 hex digits>". `dds_type` is
/// as on the wire, "geometry_msgs::msg::dds_::Twist_". Empty for a type that is not ours.
[[nodiscard]] std::string_view type_hash(std::string_view dds_type);

}  // namespace tandem::runtime
