// SPDX-License-Identifier: Apache-2.0
// Keeps track of the process's nodes so that a shutdown stops all of them. Private to runtime/.
#pragma once

namespace tandem::runtime {

class NodeCore;

namespace running_nodes {

void add(NodeCore& node);  ///< stops the node immediately if the process is shutting down
void remove(NodeCore& node);

}  // namespace running_nodes
}  // namespace tandem::runtime
