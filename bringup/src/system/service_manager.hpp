// SPDX-License-Identifier: Apache-2.0
// Reports to systemd, or to another service manager with its protocol (sd_notify), that this
// process is ready and alive.
#pragma once

namespace tandem {

/// Sends `state` ("READY=1", "WATCHDOG=1" or "STOPPING=1") to the socket named by NOTIFY_SOCKET.
/// Does nothing without that variable. A message that cannot be sent is dropped: the service
/// manager detects its absence.
void notify_service_manager(const char* state);

}  // namespace tandem
