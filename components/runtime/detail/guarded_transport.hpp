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

class WireGuard;

/// The guard of this process, with limits from its environment.
[[nodiscard]] WireGuard& process_guard();

/// Puts the process's guard in front of `transport`; null if that is not a UDP transport. Calls
/// `listening` with each port that is opened to receive.
[[nodiscard]] std::shared_ptr<TransportDescriptor> guarded(
    const std::shared_ptr<TransportDescriptor>& transport,
    std::function<void(std::uint32_t port)> listening);

}  // namespace tandem::runtime
