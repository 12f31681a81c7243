// SPDX-License-Identifier: Apache-2.0
// Creates a keystore in SROS2's layout with the OpenSSL library: identities that may join a domain
// and their permissions.
#pragma once

#include <filesystem>
#include <string>

#include "bringup/system/permissions.hpp"

namespace tandem {

/// From yesterday (clocks differ) for ten years, like SROS2's certificates.
[[nodiscard]] Validity usual_validity();

/// Creates whatever is missing: `public/`, `private/` with one authority for identities and
/// permissions, and `enclaves/governance.{xml,p7s}` for `domain`. Existing files stay unchanged.
/// Throws std::runtime_error naming the file that cannot be written.
void create_keystore(const std::filesystem::path& keystore, int domain);

/// Creates the enclave ("/a/b") in an existing keystore, which may be made by SROS2. Key and
/// certificate are kept if this authority signed them and they have not expired; the signed
/// permissions are always replaced. Throws std::invalid_argument for an invalid enclave name and
/// std::runtime_error naming the file that cannot be read or written.
void create_enclave(const std::filesystem::path& keystore, const std::string& enclave,
                    const Permissions& permissions, int domain,
                    const Validity& validity = usual_validity());

}  // namespace tandem
