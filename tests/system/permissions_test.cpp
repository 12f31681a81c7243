// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/permissions.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/secured_domain.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

// Fast DDS 3.1.2 cannot send longer ones.
TEST(Security, ThePermissionsOfEachShippedSystemInOneEnclaveAreShort) {
  const SecuredDomain domain;
  int systems = 0;
  for (const auto& entry : fs::directory_iterator{source_path("bringup/systems")}) {
    if (entry.path().extension() != ".yaml") continue;
    ++systems;
    Permissions all;
    for (const auto& node : load_system(entry.path().string()).nodes) all.add(permissions_of(node));
    domain.add("/robot", all);
    EXPECT_LE(file_size(domain.enclave("/robot") / "permissions.p7s"), kShortPermissions)
        << entry.path();
  }
  EXPECT_GE(systems, 7);
}

}  // namespace
}  // namespace tandem::test
