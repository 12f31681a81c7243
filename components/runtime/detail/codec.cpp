// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/codec.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "tandem/runtime/detail/cdr_structure.hpp"

namespace tandem::runtime {
namespace {

// Decoded elements may take several times their serialized size, so only bulk types may be large;
// 1 MiB holds 10 000 poses.
std::size_t usual_limit(std::string_view type_name) {
  constexpr std::array<std::string_view, 3> kBulk{
      "octomap_msgs/msg/Octomap", "nav_msgs/msg/OccupancyGrid", "sensor_msgs/msg/PointCloud2"};
  // Every node accepts these from any sender, and decoding can expand them fiftyfold.
  if (type_name.starts_with("rcl_interfaces/srv/")) return std::size_t{1} << 17;
  const bool bulk = std::find(kBulk.begin(), kBulk.end(), type_name) != kBulk.end();
  return bulk ? BytesType::kMaxSize : std::size_t{1} << 20;
}

// A payload that refers to our bytes without owning them.
struct PayloadView {
  explicit PayloadView(Bytes& bytes) {
    payload.data = bytes.data();
    payload.length = static_cast<uint32_t>(bytes.size());
    payload.max_size = payload.length;
  }
  ~PayloadView() { payload.data = nullptr; }
  PayloadView(const PayloadView&) = delete;
  PayloadView& operator=(const PayloadView&) = delete;

  rtps::SerializedPayload_t payload;
};

void copy_in(const Bytes& bytes, rtps::SerializedPayload_t& payload) {
  payload.encapsulation = CDR_LE;
  payload.length = static_cast<uint32_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), payload.data);
}

void copy_out(const rtps::SerializedPayload_t& payload, Bytes& bytes) {
  if (payload.length > BytesType::kMaxSize)
    bytes.clear();  // decode() rejects an empty sample
  else
    bytes.assign(payload.data, payload.data + payload.length);
}

// Size to reserve [bytes]; Fast DDS's pools do not support size 0.
std::uint32_t room_for(const void* bytes) {
  return std::max(1U, static_cast<std::uint32_t>(static_cast<const Bytes*>(bytes)->size()));
}

bool plain_cdr(const Bytes& bytes) {
  return bytes.size() > 4 && bytes[0] == 0 && (bytes[1] == 0 || bytes[1] == 1);
}

}  // namespace

std::size_t largest_sample_of(std::string_view type) {
  const CdrStructure* structure = CdrStructure::of(type);
  if (structure == nullptr) return BytesType::kMaxSize;
  constexpr std::size_t kPadding = 3;  // some writers round up to four bytes
  return structure->largest() ? *structure->largest() + kPadding : usual_limit(type);
}

Codec::Codec(const TypeRef& type)
    : type_{type.create()},
      max_size_{usual_limit(type.name)},
      structure_{CdrStructure::of(type.name)} {
#if TANDEM_FASTDDS_3
  dds_name_ = type_->get_name();
#else
  dds_name_ = type_->getName();
#endif
}

std::size_t Codec::size(const void* message) const {
#if TANDEM_FASTDDS_3
  return type_->calculate_serialized_size(message, fdds::XCDR_DATA_REPRESENTATION);
#else
  return type_->getSerializedSizeProvider(const_cast<void*>(message))();
#endif
}

bool Codec::encode(const void* message, Bytes& bytes) const {
  bytes.resize(size(message));
  if (bytes.size() > max_size_) return false;
  PayloadView view{bytes};
#if TANDEM_FASTDDS_3
  if (!type_->serialize(message, view.payload, fdds::XCDR_DATA_REPRESENTATION)) return false;
#else
  if (!type_->serialize(const_cast<void*>(message), &view.payload)) return false;
#endif
  bytes.resize(view.payload.length);
  return true;
}

bool Codec::decode_unchecked(const Bytes& bytes, void* message) const {
  PayloadView view{const_cast<Bytes&>(bytes)};  // read only
#if TANDEM_FASTDDS_3
  return type_->deserialize(view.payload, message);
#else
  return type_->deserialize(&view.payload, message);
#endif
}

bool Codec::decode(const Bytes& bytes, void* message) const {
  if (!plain_cdr(bytes) || bytes.size() > max_size_) return false;
  if (structure_ != nullptr && !structure_->fits(bytes)) return false;
  constexpr std::size_t kPadding = 3;  // some writers round up to four bytes
  try {
    return decode_unchecked(bytes, message) && bytes.size() <= size(message) + kPadding;
  } catch (...) {  // anything that generated code and Fast CDR throw on invalid bytes
    return false;
  }
}

bool decode(const std::vector<std::uint8_t>& bytes, TypeRef type, void* message) {
  return Codec{type}.decode(bytes, message);
}

std::vector<std::uint8_t> encode(TypeRef type, const void* message) {
  Bytes bytes;
  if (!Codec{type}.encode(message, bytes)) bytes.clear();
  return bytes;
}

#if TANDEM_FASTDDS_3
BytesType::BytesType(const std::string& dds_name, std::size_t largest) {
  set_name(dds_name);
  max_serialized_type_size = static_cast<std::uint32_t>(largest);
  is_compute_key_provided = false;
}
bool BytesType::serialize(const void* const data, rtps::SerializedPayload_t& payload,
                          fdds::DataRepresentationId_t) {
  copy_in(*static_cast<const Bytes*>(data), payload);
  return true;
}
bool BytesType::deserialize(rtps::SerializedPayload_t& payload, void* data) {
  copy_out(payload, *static_cast<Bytes*>(data));
  return true;
}
uint32_t BytesType::calculate_serialized_size(const void* const data,
                                              fdds::DataRepresentationId_t) {
  return room_for(data);
}
#else
BytesType::BytesType(const std::string& dds_name, std::size_t largest) {
  setName(dds_name.c_str());
  m_typeSize = static_cast<std::uint32_t>(largest);
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}
bool BytesType::serialize(void* data, rtps::SerializedPayload_t* payload) {
  copy_in(*static_cast<const Bytes*>(data), *payload);
  return true;
}
bool BytesType::deserialize(rtps::SerializedPayload_t* payload, void* data) {
  copy_out(*payload, *static_cast<Bytes*>(data));
  return true;
}
std::function<uint32_t()> BytesType::getSerializedSizeProvider(void* data) {
  return [size = room_for(data)] { return size; };
}
#endif

}  // namespace tandem::runtime
