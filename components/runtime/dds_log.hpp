// SPDX-License-Identifier: Apache-2.0
// Private to runtime/.
#pragma once

namespace tandem::runtime {

/// From now on what Fast DDS has to say is a line of our log, under the name `dds`.
void redirect_dds_log();

}  // namespace tandem::runtime
