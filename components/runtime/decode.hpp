// SPDX-License-Identifier: Apache-2.0
// In: recorded bytes. Out: the message in them.
#pragma once

#include "tandem/runtime/pubsub.hpp"

namespace tandem::runtime {

/// Reads a message of a type from plain CDR, encapsulation included, as a recording holds it. False
/// for bytes that are none.
[[nodiscard]] bool decode(const TypeRef& type, const std::vector<std::uint8_t>& bytes,
                          void* message);

}  // namespace tandem::runtime
