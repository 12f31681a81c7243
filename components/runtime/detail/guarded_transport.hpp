// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: a UDP transport whose datagrams are checked before Fast DDS parses them.
#pragma once

#include <memory>
#include <vector>

#include "tandem/runtime/detail/dds.hpp"

namespace tandem::runtime {

using TransportDescriptor = eprosima::fastdds::rtps::TransportDescriptorInterface;

/// The transport behind the process's WireGuard; null if it is not a UDP transport.
[[nodiscard]] std::shared_ptr<TransportDescriptor> guarded(
    const std::shared_ptr<TransportDescriptor>& transport);

}  // namespace tandem::runtime
