// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/service.hpp"

#include <utility>

#include "tandem/runtime/detail/service_core.hpp"

namespace tandem::runtime {

Service::Service(std::shared_ptr<NodeCore> node, std::shared_ptr<Server> server)
    : node_{std::move(node)}, server_{std::move(server)} {}

Service::~Service() { close(); }

Service& Service::operator=(Service&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  server_ = std::move(other.server_);
  return *this;
}

void Service::close() {
  if (server_) {
    server_->close();
    node_->retire(std::exchange(server_, nullptr));
  }
  node_.reset();
}

AnyClient::AnyClient(std::shared_ptr<NodeCore> node, std::shared_ptr<Caller> caller,
                     std::shared_ptr<Codec> request, std::shared_ptr<Codec> response)
    : node_{std::move(node)},
      caller_{std::move(caller)},
      request_{std::move(request)},
      response_{std::move(response)} {}

AnyClient::~AnyClient() { close(); }

AnyClient& AnyClient::operator=(AnyClient&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  caller_ = std::move(other.caller_);
  request_ = std::move(other.request_);
  response_ = std::move(other.response_);
  return *this;
}

void AnyClient::call(const void* request, Receiver response, double timeout,
                     std::function<void()> on_timeout) const {
  if (!caller_) return;
  Bytes bytes;
  if (!request_->encode(request, bytes)) bytes.clear();
  auto deliver = [codec = response_, response = std::move(response)](const Bytes& answer) {
    if (!codec->decode(answer, response.message())) return false;
    response.deliver();
    return true;
  };
  caller_->call(std::move(bytes), std::move(deliver), timeout, std::move(on_timeout));
}

void AnyClient::call_bytes(const std::vector<std::uint8_t>& request,
                           std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
                           std::function<void()> on_timeout) const {
  if (!caller_) return;
  auto deliver = [fn = std::move(fn)](const Bytes& answer) {
    fn(answer);
    return true;
  };
  caller_->call(request, std::move(deliver), timeout, std::move(on_timeout));
}

bool AnyClient::ready() const { return caller_ && caller_->ready(); }

void AnyClient::close() {
  if (caller_) {
    caller_->close();
    node_->retire(std::exchange(caller_, nullptr));
  }
  node_.reset();
}

}  // namespace tandem::runtime
