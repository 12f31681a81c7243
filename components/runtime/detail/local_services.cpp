// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/local_services.hpp"

#include <utility>

#include "tandem/runtime/detail/local_node.hpp"

namespace tandem::runtime {
namespace {

// Publishes an event of a service or client. `message` is of that type; null: bytes are given.
void tell(const std::shared_ptr<ServiceEvents>& events, ServiceEvent event,
          const PublisherId& client, std::int64_t number, TypeRef type, const void* message,
          const std::vector<std::uint8_t>& bytes = {}) {
  if (!events || !events->is_enabled()) return;
  const bool encodes = message != nullptr && events->has_contents();
  events->publish(event, client, number, encodes ? encode(type, message) : bytes);
}

}  // namespace

LocalServer::LocalServer(LocalNode& node, std::string service, Responder responder,
                         std::shared_ptr<ServiceEvents> events)
    : node_{node},
      service_{std::move(service)},
      responder_{std::move(responder)},
      events_{std::move(events)} {}

void LocalServer::close() {
  closed_ = true;
  if (events_) events_->close();
  events_.reset();
  node_.exchange().close(*this);
}

bool LocalServer::serve(const LocalPayload& request, const PublisherId& client, std::int64_t number,
                        Respond respond) {
  if (closed_ || node_.stopped()) return true;
  const Receiver& receiver = responder_.request;
  const void* message = request.message.get();
  if (message == nullptr) {
    if (!decode(request.bytes, receiver.type, receiver.message())) {
      receiver.reset();
      return false;
    }
    message = receiver.message();
  }
  const LocalNode::Running running{node_};
  const auto self = shared_from_this();  // a callback may close its own service
  tell(events_, ServiceEvent::kRequestReceived, client, number, receiver.type, message);
  const auto answer = [weak = weak_from_this(), client, number,
                       respond = std::move(respond)](const void* response) {
    const auto server = weak.lock();
    if (!server || server->closed_) return;
    tell(server->events_, ServiceEvent::kResponseSent, client, number, server->response_type(),
         response);
    respond(response);
  };
  if (responder_.reply) responder_.reply({answer, client});
  receiver.deliver(message);
  if (!responder_.reply && !closed_) answer(responder_.response());
  return true;
}

LocalClient::LocalClient(LocalNode& node, std::string service, TypeRef request,
                         std::shared_ptr<ServiceEvents> events)
    : LocalClient{node, std::move(service), std::string{request.name}, std::move(events)} {
  request_ = request;
}

LocalClient::LocalClient(LocalNode& node, std::string service, std::string request_type,
                         std::shared_ptr<ServiceEvents> events)
    : node_{node},
      exchange_{node.exchange()},
      service_{std::move(service)},
      request_type_{std::move(request_type)},
      events_{std::move(events)},
      id_{exchange_.new_id()} {}

void LocalClient::close() {
  closed_ = true;
  if (events_) events_->close();
  events_.reset();
  waiting_.clear();
  exchange_.forget(id_);
}

bool LocalClient::ready() const { return exchange_.server(service_, request_type_) != nullptr; }

void LocalClient::call(const void* request, Receiver response, double timeout,
                       std::function<void()> on_timeout) {
  auto deliver = [response = std::move(response)](const void* answer, TypeRef) {
    response.deliver(answer);
  };
  start(std::make_shared<Call>(
            Call{{.message = request_.copy(request)}, std::move(deliver), std::move(on_timeout)}),
        timeout);
}

void LocalClient::call_bytes(const std::vector<std::uint8_t>& request,
                             std::function<void(const std::vector<std::uint8_t>&)> fn,
                             double timeout, std::function<void()> on_timeout) {
  auto deliver = [fn = std::move(fn)](const void* answer, TypeRef type) {
    fn(encode(type, answer));
  };
  start(std::make_shared<Call>(Call{{.bytes = request}, std::move(deliver), std::move(on_timeout)}),
        timeout);
}

void LocalClient::start(std::shared_ptr<Call> call, double timeout) {
  exchange_.events().post_at(exchange_.events().now() + timeout, EventQueue::Rank::kTimer,
                             [this, self = shared_from_this(), call] { expire(*call); });
  if (ready()) return send(call);
  if (waiting_.empty()) exchange_.wait_for_server(service_, shared_from_this());
  waiting_.push_back(std::move(call));
}

void LocalClient::send_waiting() {
  if (!ready()) return exchange_.wait_for_server(service_, shared_from_this());
  for (const auto& call : std::exchange(waiting_, {})) send(call);
}

void LocalClient::send(const std::shared_ptr<Call>& call) {
  const auto server = exchange_.server(service_, request_type_);
  call->number = ++sent_;
  tell(events_, ServiceEvent::kRequestSent, id_, call->number, request_,
       call->request.message.get(), call->request.bytes);
  exchange_.events().post([this, self = shared_from_this(), server, call] {
    const auto respond = [this, self, call, type = server->response_type()](const void* response) {
      exchange_.events().post(
          [this, self, call, copy = type.copy(response), type] { answer(call, copy.get(), type); });
    };
    if (closed_ || call->is_over) return;
    if (!server->serve(call->request, id_, call->number, respond) && !closed_)
      node_.log.warn_every(1.0, "{}: the request is not a valid {}", service_, request_type_);
  });
}

void LocalClient::answer(const std::shared_ptr<Call>& call, const void* response, TypeRef type) {
  if (closed_ || node_.stopped() || std::exchange(call->is_over, true)) return;
  const LocalNode::Running running{node_};
  tell(events_, ServiceEvent::kResponseReceived, id_, call->number, type, response);
  call->on_response(response, type);
}

void LocalClient::expire(Call& call) {
  if (closed_ || node_.stopped() || std::exchange(call.is_over, true)) return;
  const LocalNode::Running running{node_};
  if (call.on_timeout)
    call.on_timeout();
  else
    node_.log.warn("{}: no answer in time", service_);
}

}  // namespace tandem::runtime
