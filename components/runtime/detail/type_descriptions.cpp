// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/type_descriptions.hpp"

#include <set>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "ros2_schema.hpp"
#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

using type_description_interfaces::msg::IndividualTypeDescription;
using type_description_interfaces::msg::TypeSource;
using type_description_interfaces::srv::GetTypeDescription;

// As rosidl writes it: truth values are Python's.
std::string default_of(const DescribedField& field) {
  if (field.default_value == "true") return "True";
  return field.default_value == "false" ? "False" : std::string{field.default_value};
}

IndividualTypeDescription describe(const DescribedType& type) {
  IndividualTypeDescription description;
  description.type_name() = std::string{type.name};
  for (const DescribedField& field : type.fields) {
    auto& out = description.fields().emplace_back();
    out.name() = field.name;
    out.type().type_id(field.type_id);
    out.type().capacity(field.capacity);
    out.type().string_capacity(field.string_capacity);
    out.type().nested_type_name() = std::string{field.nested};
    out.default_value() = default_of(field);
  }
  return description;
}

// As rcl gives it: a request or response has no file of its own.
TypeSource source_of(std::string_view type) {
  const bool of_service =
      type.ends_with("_Request") || type.ends_with("_Response") || type.ends_with("_Event");
  TypeSource source;
  source.type_name(std::string{type});
  source.encoding(of_service ? "implicit" : "msg");
  if (!of_service) source.raw_file_contents(*msg_file(type));
  return source;
}

// Collects the types nested in `type`, sorted by name as REP-2016 requires.
void collect(const DescribedType& type, std::set<std::string_view>& found) {
  for (const DescribedField& field : type.fields)
    if (!field.nested.empty() && found.insert(field.nested).second)
      collect(*described_type(field.nested), found);
}

}  // namespace

GetTypeDescription::Response describe_type(const GetTypeDescription::Request& request) {
  GetTypeDescription::Response answer;
  const DescribedType* type = described_type(request.type_name());
  if (type == nullptr) {
    answer.failure_reason("this node has no type of that name");
    return answer;
  }
  if (!request.type_hash().empty() && request.type_hash() != type->hash) {
    answer.failure_reason(fmt::format("this node's {} is {}", type->name, type->hash));
    return answer;
  }
  answer.successful(true);
  answer.type_description().type_description(describe(*type));
  std::set<std::string_view> nested;
  collect(*type, nested);
  for (const auto name : nested)
    answer.type_description().referenced_type_descriptions().push_back(
        describe(*described_type(name)));
  if (!request.include_type_sources()) return answer;
  answer.type_sources().push_back(source_of(type->name));
  for (const auto name : nested) answer.type_sources().push_back(source_of(name));
  return answer;
}

}  // namespace tandem::runtime
