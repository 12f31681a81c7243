// SPDX-License-Identifier: Apache-2.0
// Explains why DDS rejects an enclave, because DDS does not. Private to runtime/.
#pragma once

#include <string>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Describes the first fault in the files of an enclave's folder, such as "cert.pem has expired".
/// Empty if keys, certificates and signatures are consistent.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS std::string security_fault(const std::string& folder);

}  // namespace tandem::runtime
