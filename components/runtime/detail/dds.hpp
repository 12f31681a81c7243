// SPDX-License-Identifier: Apache-2.0
// Hides the API differences between Fast DDS 2.9 and 3.1 behind common names. Private to runtime/.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <fastdds/dds/core/condition/GuardCondition.hpp>
#include <fastdds/dds/core/condition/StatusCondition.hpp>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#if __has_include(<fastdds/config.hpp>)
#define TANDEM_FASTDDS_3 1
#include <fastdds/rtps/common/WriteParams.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#else
#define TANDEM_FASTDDS_3 0
#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#endif

namespace tandem::runtime {

namespace fdds = eprosima::fastdds::dds;
#if TANDEM_FASTDDS_3
namespace rtps = eprosima::fastdds::rtps;
using DdsDuration = fdds::Duration_t;
inline constexpr const char *kProfilesVariable = "FASTDDS_DEFAULT_PROFILES_FILE",
                            *kOtherProfilesVariable = "FASTRTPS_DEFAULT_PROFILES_FILE";
inline bool ok(fdds::ReturnCode_t code) { return code == fdds::RETCODE_OK; }
#else
namespace rtps = eprosima::fastrtps::rtps;
using DdsDuration = eprosima::fastrtps::Duration_t;
inline constexpr const char *kProfilesVariable = "FASTRTPS_DEFAULT_PROFILES_FILE",
                            *kOtherProfilesVariable = "FASTDDS_DEFAULT_PROFILES_FILE";
inline bool ok(bool done) { return done; }
inline bool ok(const eprosima::fastrtps::types::ReturnCode_t& code) {
  return code == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
}
#endif
using IpLocator = rtps::IPLocator;

using Bytes = std::vector<std::uint8_t>;

/// Converts seconds to a DDS duration; infinite from 10⁸ s on.
inline DdsDuration to_duration(double seconds) {
  if (seconds >= 1e8) return DdsDuration{0x7fffffff, 0xffffffff};
  const auto whole = static_cast<std::int32_t>(seconds);
  return DdsDuration{whole, static_cast<std::uint32_t>((seconds - whole) * 1e9)};
}

}  // namespace tandem::runtime
