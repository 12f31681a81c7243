// SPDX-License-Identifier: Apache-2.0
// Wraps a UDP transport to check datagrams before Fast DDS parses them. Private to runtime/.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "tandem/runtime/detail/dds.hpp"

namespace tandem::runtime {

using TransportDescriptor = eprosima::fastdds::rtps::TransportDescriptorInterface;

/// Puts the process's WireGuard in front of `transport`; null if that is not a UDP transport. Calls
/// `listening` with each port that is opened to receive.
[[nodiscard]] std::shared_ptr<TransportDescriptor> guarded(
    const std::shared_ptr<TransportDescriptor>& transport,
    std::function<void(std::uint32_t port)> listening);

}  // namespace tandem::runtime
