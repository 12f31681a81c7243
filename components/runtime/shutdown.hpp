// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Installs handlers for SIGINT, SIGTERM and SIGHUP (unless ignored, as under nohup) that stop
/// every node of the process. A second signal other than SIGHUP exits immediately.
TANDEM_EXPORT void install_signal_handlers();

/// Stops every node of the process, present and future. May be called by any thread.
TANDEM_EXPORT void shutdown();
/// Whether shutdown() was called or a signal came. Any thread may ask.
[[nodiscard]] TANDEM_EXPORT bool shutting_down();

/// Returns after shutdown() or a signal.
TANDEM_EXPORT void wait_for_shutdown();
/// Waits at most `max_wait` [s]; returns true if shutting down.
TANDEM_EXPORT bool wait_for_shutdown(double max_wait);

}  // namespace tandem::runtime
