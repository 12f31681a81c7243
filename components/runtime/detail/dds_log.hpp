// SPDX-License-Identifier: Apache-2.0
// Private to runtime/.
#pragma once

#include <string>

namespace tandem::runtime {

/// From now on what Fast DDS has to say is a line of our log, under the name `dds`.
void redirect_dds_log();

/// What DDS logged as errors while this lives: its calls return no reason.
class DdsErrors {
 public:
  DdsErrors();
  ~DdsErrors();
  DdsErrors(const DdsErrors&) = delete;
  DdsErrors& operator=(const DdsErrors&) = delete;
  /// The first one, which the others follow from; empty if there is none.
  [[nodiscard]] std::string first() const;
};

}  // namespace tandem::runtime
