// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tandem::runtime {

/// SIGINT, SIGTERM and SIGHUP (a terminal that is closed; not under nohup) then stop every node of
/// the process; a second one exits at once, but for SIGHUP.
void install_signal_handlers();

/// Stops every node of the process, present and future. May be called by any thread.
void shutdown();
[[nodiscard]] bool shutting_down();

/// Returns after shutdown() or a signal.
void wait_for_shutdown();
/// The same, but waits at most `max_wait` [s]; true if shutting down.
bool wait_for_shutdown(double max_wait);

}  // namespace tandem::runtime
