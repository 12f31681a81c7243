// SPDX-License-Identifier: Apache-2.0
// Encodes and decodes messages, and defines the DDS type that carries all samples as bytes. Private
// to runtime/.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class CdrStructure;

/// The largest accepted sample [bytes] of a type such as "sensor_msgs/msg/Joy": its maximum
/// serialized size if bounded, otherwise 64 MiB for bulk and unknown types, 128 KiB for
/// rcl_interfaces services and 1 MiB for the rest.
[[nodiscard]] std::size_t largest_sample_of(std::string_view type);

/// Encodes and decodes one message type as plain CDR.
class TANDEM_EXPORT_FOR_TESTS Codec {
 public:
  explicit Codec(const TypeRef& type);

  [[nodiscard]] const std::string& dds_name() const { return dds_name_; }

  /// False if the message cannot be encoded or is larger than a receiver would accept.
  bool encode(const void* message, Bytes& bytes) const;
  /// Returns false, and never throws, for invalid bytes: truncated, too long, lengths beyond the
  /// end, invalid booleans. Number values are not checked (NaN passes).
  bool decode(const Bytes& bytes, void* message) const;

 private:
  [[nodiscard]] std::size_t size(const void* message) const;
  bool decode_unchecked(const Bytes& bytes, void* message) const;

  std::shared_ptr<fdds::TopicDataType> type_;
  std::string dds_name_;
  std::size_t max_size_;
  const CdrStructure* structure_;  // null for a type that is not in idl/
};

/// The DDS type of all our readers and writers: the sample's bytes including encapsulation. DDS
/// itself decodes nothing, so only Codec::decode handles untrusted bytes.
class BytesType final : public fdds::TopicDataType {
 public:
  static constexpr std::size_t kMaxSize = std::size_t{64} << 20;  // a larger sample arrives empty

  /// `largest`: maximum sample in a reader's history [bytes].
  BytesType(const std::string& dds_name, std::size_t largest);

#if TANDEM_FASTDDS_3
  bool serialize(const void* const data, rtps::SerializedPayload_t& payload,
                 fdds::DataRepresentationId_t) override;
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override;
  uint32_t calculate_serialized_size(const void* const data, fdds::DataRepresentationId_t) override;
  void* create_data() override { return new Bytes; }
  void delete_data(void* data) override { delete static_cast<Bytes*>(data); }
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) override {
    return false;
  }
  bool compute_key(const void* const, rtps::InstanceHandle_t&, bool) override { return false; }
#else
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override;
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override;
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
#endif
};

}  // namespace tandem::runtime
