// SPDX-License-Identifier: Apache-2.0
#include "runtime/decode.hpp"

#include "runtime/codec.hpp"

namespace tandem::runtime {

bool decode(const TypeRef& type, const std::vector<std::uint8_t>& bytes, void* message) {
  return Codec{type}.decode(bytes, message);
}

}  // namespace tandem::runtime
