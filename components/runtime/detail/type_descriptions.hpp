// SPDX-License-Identifier: Apache-2.0
// Describes the types of idl/ to tools that know only their names. Private to runtime/.
#pragma once

#include <msgs.hpp>

namespace tandem::runtime {

/// Answers ~/get_type_description for the structures of idl/*.idl: the description of
/// REP-2016, and sources if they are asked for. For other types and for a different hash, returns
/// `successful` false and the reason; an empty hash matches any.
[[nodiscard]] type_description_interfaces::srv::GetTypeDescription::Response describe_type(
    const type_description_interfaces::srv::GetTypeDescription::Request& request);

}  // namespace tandem::runtime
