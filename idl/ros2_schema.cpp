// SPDX-License-Identifier: Apache-2.0
#include "ros2_schema.hpp"

#include <array>
#include <set>

#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

// Codes of type_description_interfaces/msg/FieldType: container kind and element type.
constexpr int kKinds = 48, kNested = 1, kBoundedString = 21;
enum class Kind { kOne, kArray, kBoundedSequence, kSequence };
constexpr std::array<const char*, 23> kNames{
    "",      "",       "int8",    "uint8",   "int16", "uint16",   "int32",    "uint32",
    "int64", "uint64", "float32", "float64", "",      "char",     "wchar",    "bool",
    "byte",  "string", "wstring", "",        "",      "string<=", "wstring<="};

// "builtin_interfaces/msg/Time" → "builtin_interfaces/Time"
std::string short_name(std::string_view type) {
  const auto first = type.find('/'), last = type.rfind('/');
  return std::string{type.substr(0, first)} + std::string{type.substr(last)};
}

// "byte", "string<="
const char* basic(int id) { return kNames.at(static_cast<std::size_t>(id)); }

std::string element(const DescribedField& field) {
  const int id = field.type_id % kKinds;
  if (id == kNested) return short_name(field.nested);
  std::string name = basic(id);
  if (id >= kBoundedString) name += std::to_string(field.string_capacity);
  return name;
}

std::string suffix(const DescribedField& field) {
  switch (static_cast<Kind>(field.type_id / kKinds)) {
    case Kind::kOne:
      return "";
    case Kind::kArray:
      return "[" + std::to_string(field.capacity) + "]";
    case Kind::kBoundedSequence:
      return "[<=" + std::to_string(field.capacity) + "]";
    case Kind::kSequence:
      break;
  }
  return "[]";
}

std::string members_of(const DescribedType& type) {
  std::string text;
  for (const auto& constant : type.constants)
    text += std::string{basic(constant.type_id)} + " " + std::string{constant.name} + "=" +
            std::string{constant.value} + "\n";
  for (const auto& field : type.fields)
    text += element(field) + suffix(field) + " " + std::string{field.name} +
            (field.default_value.empty() ? "" : " ") + std::string{field.default_value} + "\n";
  return text;
}

void collect(const DescribedType& type, std::set<std::string_view>& found) {
  for (const auto& field : type.fields)
    if (!field.nested.empty() && found.insert(field.nested).second)
      collect(*described_type(field.nested), found);
}

}  // namespace

std::optional<std::string> msg_file(std::string_view type) {
  const DescribedType* described = described_type(type);
  if (described == nullptr) return std::nullopt;
  return members_of(*described);
}

std::optional<std::string> ros2msg(std::string_view type) {
  const DescribedType* described = described_type(type);
  if (described == nullptr) return std::nullopt;
  std::string text = members_of(*described);
  std::set<std::string_view> nested;
  collect(*described, nested);
  for (const auto name : nested)
    text += std::string(80, '=') + "\nMSG: " + short_name(name) + "\n" +
            members_of(*described_type(name));
  return text;
}

}  // namespace tandem::runtime
