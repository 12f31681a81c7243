// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/sample.hpp"

namespace tandem::runtime {

const std::vector<std::uint8_t>& Sample::bytes() const {
  if (message_) std::call_once(encoded_, [this] { bytes_ = encode(type_, message_.get()); });
  return bytes_;
}

bool deliver(const Sample& sample, const Receiver& receiver) {
  if (sample.message() != nullptr) {
    receiver.deliver(sample.message());
    return true;
  }
  if (!decode(sample.bytes(), receiver.type, receiver.message())) {
    receiver.reset();
    return false;
  }
  receiver.deliver(receiver.message());
  return true;
}

}  // namespace tandem::runtime
