// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: what a type of ours looks like, for those who know only its name.
#pragma once

#include <msgs.hpp>

namespace tandem::runtime {

/// Answers ~/get_type_description for the structures of idl/*.idl: the description as REP-2016
/// hashes it, without default values and sources. Not successful, with the reason, for other types
/// and for another hash than ours; an empty hash stands for any.
[[nodiscard]] type_description_interfaces::srv::GetTypeDescription::Response describe_type(
    const type_description_interfaces::srv::GetTypeDescription::Request& request);

}  // namespace tandem::runtime
