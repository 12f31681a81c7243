// SPDX-License-Identifier: Apache-2.0
// Explains why DDS rejects an enclave, because DDS does not. Private to runtime/.
#pragma once

#include <string>

namespace tandem::runtime {

/// The first thing that is wrong with the files of an enclave's folder: "cert.pem has expired".
/// Empty if keys, certificates and signatures fit together.
[[nodiscard]] std::string security_fault(const std::string& folder);

}  // namespace tandem::runtime
