// SPDX-License-Identifier: Apache-2.0
// Two modules that must not be loaded: libtandem_outdated.so, whose mark names another version, and
// libtandem_unmarked.so, without a mark. Both set an environment variable as soon as they run.
#include <cstdlib>

#include "tandem/runtime/module_mark.hpp"

namespace {

[[maybe_unused]] const int kHasRun = setenv("TANDEM_REFUSED_MODULE_HAS_RUN", "1", 1);

#ifdef TANDEM_TEST_ABI
[[gnu::used, gnu::section(".note.tandem"),
  gnu::aligned(4)]] constexpr tandem::runtime::ModuleMark kMark{.abi = TANDEM_TEST_ABI,
                                                                .component = "outdated"};
#endif

}  // namespace
