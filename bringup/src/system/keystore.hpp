// SPDX-License-Identifier: Apache-2.0
// A keystore laid out as SROS2's, made by OpenSSL's library: who may join a domain, and what each
// may do there.
#pragma once

#include <filesystem>
#include <string>

#include "bringup/system/permissions.hpp"

namespace tandem {

/// From yesterday (clocks differ) for ten years, as SROS2's.
[[nodiscard]] Validity usual_validity();

/// Makes what is missing: `public/`, `private/` with one authority for identities and permissions,
/// and `enclaves/governance.{xml,p7s}` for `domain`. Nothing that is there is changed. Throws
/// std::runtime_error naming the file that cannot be written.
void create_keystore(const std::filesystem::path& keystore, int domain);

/// Makes the enclave ("/a/b") in an existing keystore, SROS2's own too: key and certificate, unless
/// there are some that this authority signed and that have not expired, and its signed permissions,
/// which replace those that are there. Throws std::invalid_argument for a name that is no enclave's
/// and std::runtime_error naming the file that cannot be read or written.
void create_enclave(const std::filesystem::path& keystore, const std::string& enclave,
                    const Permissions& permissions, int domain,
                    const Validity& validity = usual_validity());

}  // namespace tandem
