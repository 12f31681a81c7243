// SPDX-License-Identifier: Apache-2.0
// Service servers and clients on a LocalBus. Private to runtime/.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/local_exchange.hpp"
#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/detail/service_events.hpp"

namespace tandem::runtime {

class LocalNode;

/// A request or a response, as a message or as bytes.
struct LocalPayload {
  std::shared_ptr<const void> message = {};
  std::vector<std::uint8_t> bytes = {};
};

/// Answers requests.
class LocalServer final : public ServicePort, public std::enable_shared_from_this<LocalServer> {
 public:
  using Respond = std::function<void(const void* response)>;

  LocalServer(LocalNode& node, std::string service, Responder responder,
              std::shared_ptr<ServiceEvents> events);
  void close() override;

  /// Answers by `respond`, now or later. Returns false for bytes that are not a request. `number`:
  /// of the request among those of its client.
  bool serve(const LocalPayload& request, const PublisherId& client, std::int64_t number,
             Respond respond);

  [[nodiscard]] const std::string& service() const { return service_; }
  [[nodiscard]] std::string request_type() const { return responder_.request.type.name; }
  [[nodiscard]] TypeRef response_type() const { return responder_.response_type; }

 private:
  LocalNode& node_;
  std::string service_;
  Responder responder_;
  std::shared_ptr<ServiceEvents> events_;  // null: none are published, or closed
  bool closed_ = false;
};

/// Sends requests, which wait until there is a server.
class LocalClient final : public ClientPort, public std::enable_shared_from_this<LocalClient> {
 public:
  LocalClient(LocalNode& node, std::string service, TypeRef request,
              std::shared_ptr<ServiceEvents> events);
  /// For bytes of a type known only by name.
  LocalClient(LocalNode& node, std::string service, std::string request_type,
              std::shared_ptr<ServiceEvents> events);
  void call(const void* request, Receiver response, double timeout,
            std::function<void()> on_timeout) override;
  void call_bytes(const std::vector<std::uint8_t>& request,
                  std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
                  std::function<void()> on_timeout) override;
  [[nodiscard]] bool ready() const override;
  void close() override;

  /// Sends the requests that waited for a server.
  void send_waiting();

 private:
  struct Call {
    LocalPayload request;
    std::function<void(const void* response, TypeRef type)> on_response;
    std::function<void()> on_timeout;
    std::int64_t number = 0;
    bool is_over = false;
  };
  void start(std::shared_ptr<Call> call, double timeout);
  void send(const std::shared_ptr<Call>& call);
  void answer(const std::shared_ptr<Call>& call, const void* response, TypeRef type);
  void expire(Call& call);

  LocalNode& node_;  // not to be used once closed
  LocalExchange& exchange_;
  std::string service_;
  TypeRef request_{};
  std::string request_type_;
  std::shared_ptr<ServiceEvents> events_;  // null once closed
  PublisherId id_;
  std::int64_t sent_ = 0;  // requests
  std::deque<std::shared_ptr<Call>> waiting_;
  bool closed_ = false;
};

}  // namespace tandem::runtime
