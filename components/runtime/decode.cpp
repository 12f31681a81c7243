// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/decode.hpp"

#include "tandem/runtime/detail/codec.hpp"

namespace tandem::runtime {

bool decode(const TypeRef& type, const std::vector<std::uint8_t>& bytes, void* message) {
  return Codec{type}.decode(bytes, message);
}

}  // namespace tandem::runtime
