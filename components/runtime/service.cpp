// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/service.hpp"

#include <utility>

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

Service::Service(std::shared_ptr<NodeCore> node, std::shared_ptr<ServicePort> port)
    : node_{std::move(node)}, port_{std::move(port)} {}

Service::~Service() { close(); }

Service& Service::operator=(Service&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  port_ = std::move(other.port_);
  return *this;
}

void Service::close() {
  if (port_) {
    port_->close();
    node_->retire(std::exchange(port_, nullptr));
  }
  node_.reset();
}

AnyClient::AnyClient(std::shared_ptr<NodeCore> node, std::shared_ptr<ClientPort> port)
    : node_{std::move(node)}, port_{std::move(port)} {}

AnyClient::~AnyClient() { close(); }

AnyClient& AnyClient::operator=(AnyClient&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  port_ = std::move(other.port_);
  return *this;
}

void AnyClient::call(const void* request, Receiver response, double timeout,
                     std::function<void()> on_timeout) const {
  if (port_) port_->call(request, std::move(response), timeout, std::move(on_timeout));
}

void AnyClient::call_bytes(const std::vector<std::uint8_t>& request,
                           std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
                           std::function<void()> on_timeout) const {
  if (port_) port_->call_bytes(request, std::move(fn), timeout, std::move(on_timeout));
}

bool AnyClient::ready() const { return port_ && port_->ready(); }

void AnyClient::close() {
  if (port_) {
    port_->close();
    node_->retire(std::exchange(port_, nullptr));
  }
  node_.reset();
}

}  // namespace tandem::runtime
