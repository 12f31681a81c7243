// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/worker.hpp"

#include <utility>

#include "tandem/runtime/detail/ports.hpp"

namespace tandem::runtime {

Worker::Worker(std::shared_ptr<WorkerPort> port) : port_{std::move(port)} {}

Worker::~Worker() { close(); }

Worker& Worker::operator=(Worker&& other) noexcept {
  if (this == &other) return *this;
  close();
  port_ = std::move(other.port_);
  return *this;
}

void Worker::wake() const {
  if (port_) port_->wake();
}

void Worker::close() {
  if (port_) port_->close();
  port_.reset();
}

}  // namespace tandem::runtime
