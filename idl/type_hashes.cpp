// SPDX-License-Identifier: Apache-2.0
#include "type_hashes.hpp"

#include <map>
#include <mutex>
#include <string>

namespace tandem::runtime {
namespace {

struct Types {
  std::mutex mutex;
  std::map<std::string_view, const DescribedType*> by_name;
};

Types& types() {
  static Types all;
  return all;
}

// "a::msg::dds_::B_" → "a/msg/B"; empty for a name of another form.
std::string ros_form(std::string_view dds_type) {
  const auto first = dds_type.find("::"), last = dds_type.find("::dds_::");
  if (first >= last || last == std::string_view::npos || !dds_type.ends_with('_')) return {};
  std::string name{dds_type.substr(0, first)};
  name.append("/").append(dds_type.substr(first + 2, last - first - 2)).append("/");
  return name.append(dds_type.substr(last + 8, dds_type.size() - last - 9));
}

}  // namespace

bool add_described_types(std::span<const DescribedType> added) {
  const std::lock_guard lock{types().mutex};
  for (const DescribedType& type : added) types().by_name.emplace(type.name, &type);
  return true;
}

const DescribedType* described_type(std::string_view name) {
  const std::lock_guard lock{types().mutex};
  const auto found = types().by_name.find(name);
  return found == types().by_name.end() ? nullptr : found->second;
}

std::string_view type_hash(std::string_view dds_type) {
  const DescribedType* type = described_type(ros_form(dds_type));
  return type == nullptr ? std::string_view{} : type->hash;
}

}  // namespace tandem::runtime
