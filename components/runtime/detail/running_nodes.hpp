// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: the nodes of this process, for a shutdown that reaches all of them.
#pragma once

namespace tandem::runtime {

class NodeCore;

namespace running_nodes {

void add(NodeCore& node);  ///< stops it at once if the process is shutting down
void remove(NodeCore& node);

}  // namespace running_nodes
}  // namespace tandem::runtime
