// SPDX-License-Identifier: Apache-2.0
// Decodes recorded messages.
#pragma once

#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Decodes a message from plain CDR with its encapsulation header, as recordings store it. Returns
/// false if the bytes are not a valid message of the type.
[[nodiscard]] TANDEM_EXPORT bool decode(const TypeRef& type, const std::vector<std::uint8_t>& bytes,
                                        void* message);

}  // namespace tandem::runtime
