// SPDX-License-Identifier: Apache-2.0
// Generated DDS types that report malformed bytes by a return value instead of an exception.
#pragma once

#include <exception>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <memory>

namespace tandem::runtime {

/// A generated DDS type whose deserialize() returns false on malformed bytes. Generated code does
/// not catch all exceptions of Fast CDR, for example the one for a boolean that is neither 0 nor 1.
template <class PubSubType>
class CheckedType final : public PubSubType {
 public:
#if __has_include(<fastdds/config.hpp>)  // Fast DDS 3
  using Payload = eprosima::fastdds::rtps::SerializedPayload_t&;
#else
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t*;
#endif
  bool deserialize(Payload payload, void* data) override {
    try {
      return PubSubType::deserialize(payload, data);
    } catch (const std::exception&) {
      return false;
    }
  }
};

template <class PubSubType>
std::unique_ptr<eprosima::fastdds::dds::TopicDataType> create_checked() {
  return std::make_unique<CheckedType<PubSubType>>();
}

}  // namespace tandem::runtime
