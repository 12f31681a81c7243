// SPDX-License-Identifier: Apache-2.0
// Redirects Fast DDS's log to ours and captures its errors. Private to runtime/.
#pragma once

#include <string>

namespace tandem::runtime {

/// Sends Fast DDS's log messages to this runtime's log, under the name `dds`.
void redirect_dds_log();

/// Captures the errors that DDS logs during this object's lifetime, because DDS calls return no
/// reason.
class DdsErrors {
 public:
  DdsErrors();
  ~DdsErrors();
  DdsErrors(const DdsErrors&) = delete;
  DdsErrors& operator=(const DdsErrors&) = delete;
  /// The first error, which usually causes the others; empty if there is none.
  [[nodiscard]] std::string first() const;
};

}  // namespace tandem::runtime
