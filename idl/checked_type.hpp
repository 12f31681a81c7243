// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <memory>

namespace tandem::runtime {

/// A generated DDS type whose deserialize() throws nothing: generated code lets through, for
/// example, what Fast CDR throws at a boolean that is neither 0 nor 1.
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
