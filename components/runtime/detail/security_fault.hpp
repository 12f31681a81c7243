// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: why DDS refuses an enclave, which it does not say itself.
#pragma once

#include <string>

namespace tandem::runtime {

/// The first thing that is wrong with the files of an enclave's folder: "cert.pem has expired".
/// Empty if keys, certificates and signatures fit together.
[[nodiscard]] std::string security_fault(const std::string& folder);

}  // namespace tandem::runtime
