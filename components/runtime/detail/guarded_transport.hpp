// SPDX-License-Identifier: Apache-2.0
// Wraps a UDP transport to check datagrams before Fast DDS parses them. Private to runtime/.
#pragma once

#include <memory>
#include <vector>

#include "tandem/runtime/detail/dds.hpp"

namespace tandem::runtime {

using TransportDescriptor = eprosima::fastdds::rtps::TransportDescriptorInterface;

/// Puts the process's WireGuard in front of `transport`; null if that is not a UDP transport.
[[nodiscard]] std::shared_ptr<TransportDescriptor> guarded(
    const std::shared_ptr<TransportDescriptor>& transport);

}  // namespace tandem::runtime
