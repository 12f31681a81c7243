// SPDX-License-Identifier: Apache-2.0
// The dashboard's page in a real browser (browser/browser_test.mjs), to which a busy machine is a
// slow one: nothing runs beside it. Installed by tests/interop/build_peers; skipped where it could
// not be.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 250.0;  // [s]

TEST(Browser, DrivesTheRobotAndTakesTheUserTest) {
  const fs::path modules = peers_path("browser"), chromium = "/usr/bin/chromium",
                 node = "/usr/bin/node";
  for (const fs::path& needed : {modules / "node_modules", chromium, node})
    if (!fs::exists(needed)) GTEST_SKIP() << "NOT TESTED: there is no " << needed;
  ChildProcess browser{node,
                       {source_path("tests/dashboard/browser/browser_test.mjs"), modules,
                        binary_path("tandem"), source_path("bringup/systems"), chromium}};
  EXPECT_EQ(browser.wait(kTimeout), 0);
}

}  // namespace
}  // namespace tandem::test
