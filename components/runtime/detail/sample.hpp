// SPDX-License-Identifier: Apache-2.0
// A published message on its way to subscriptions of the same process. Private to runtime/.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A published message, shared by all that receive it. Once it is published, any thread may read
/// it.
class TANDEM_EXPORT_FOR_TESTS Sample {
 public:
  Sample(TypeRef type, std::shared_ptr<const void> message)
      : type_{type}, message_{std::move(message)} {}
  explicit Sample(std::vector<std::uint8_t> bytes) : bytes_{std::move(bytes)} {}

  /// The message; null if it was published as bytes.
  [[nodiscard]] const void* message() const { return message_.get(); }
  /// The message serialized, when first asked for.
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const;

  PublisherId sender{};
  std::uint64_t number = 0;  ///< among those of its sender, from 1
  double published = 0.0;    ///< [s] on the steady clock of its bus

 private:
  TypeRef type_{};
  std::shared_ptr<const void> message_;
  mutable std::once_flag encoded_;
  mutable std::vector<std::uint8_t> bytes_;
};

/// Calls the receiver's function with the message. Returns false, without a call, if its bytes are
/// not a message of the receiver's type.
[[nodiscard]] bool deliver(const Sample& sample, const Receiver& receiver);

}  // namespace tandem::runtime
