// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/node_thread.hpp"

#include <pthread.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <limits>
#include <stdexcept>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/wake_up.hpp"
#include "tandem/runtime/real_time.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

std::vector<DdsNode*> on_dds(const std::vector<Node*>& nodes) {
  std::vector<DdsNode*> cores;
  for (const Node* node : nodes) {
    cores.push_back(dynamic_cast<DdsNode*>(node->core().get()));
    if (cores.back() == nullptr)
      throw std::invalid_argument(node->fully_qualified_name() +
                                  " is on a LocalBus, which runs it without a thread");
  }
  return cores;
}

// So that `top -H` and a profile say which node a thread belongs to.
void name_this_thread(const std::string& name) {
  constexpr std::size_t kLongest = 15;  // of Linux
  pthread_setname_np(pthread_self(), name.substr(0, kLongest).c_str());
}

// Calls `run`. An exception ends the process.
template <class Run>
auto or_exit(DdsNode& node, Run run) {
  try {
    return run();
  } catch (const std::exception& error) {
    node.log.error("exception in a callback; the process exits: {}", error.what());
    std::_Exit(EXIT_FAILURE);
  }
}

void spin(const std::vector<DdsNode*>& nodes) {
  const auto wake_up = std::make_shared<WakeUp>();
  for (DdsNode* node : nodes) or_exit(*node, [&] { node->join(wake_up); });
  while (
      !std::all_of(nodes.begin(), nodes.end(), [](const auto* node) { return node->stopped(); })) {
    double next = std::numeric_limits<double>::infinity();
    for (DdsNode* node : nodes)
      next = std::min(next, or_exit(*node, [node] { return node->run_if_due(); }));
    wake_up->wait(next - steady_seconds());
  }
}

}  // namespace

NodeThread::NodeThread(const std::string& name, const std::vector<Node*>& nodes, int priority)
    : nodes_{nodes}, thread_{[name, priority, cores = on_dds(nodes)] {
        name_this_thread(name);
        if (priority > 0) use_real_time(name, priority);
        spin(cores);
      }} {}

NodeThread::~NodeThread() {
  for (Node* node : nodes_) node->stop();
  join();
}

void NodeThread::join() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace tandem::runtime
