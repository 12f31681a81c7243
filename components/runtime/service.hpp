// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A service: its name (ROS 2 form) and its type S with S::Request and S::Response.
template <class S>
struct ServiceName {
  const char* name;  ///< relative to the node's namespace, unless it begins with / or ~
};

class ServicePort;
class ClientPort;

/// A service found on the domain, for example "/arbitration/set_policy" of type
/// "tandem_msgs/srv/SetPolicy".
struct ServiceInfo {
  std::string name, type;  ///< ROS 2's names
};

/// Answers requests until it is destroyed.
class TANDEM_EXPORT Service {
 public:
  Service() = default;
  /// Made by Node::create_service().
  Service(std::shared_ptr<NodeCore> node, std::shared_ptr<ServicePort> port);
  ~Service();
  Service(Service&&) noexcept = default;
  Service& operator=(Service&& other) noexcept;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<ServicePort> port_;
};

/// The type-erased part of `Client<S>`.
class TANDEM_EXPORT AnyClient {
 public:
  AnyClient() = default;
  /// Made by Node.
  AnyClient(std::shared_ptr<NodeCore> node, std::shared_ptr<ClientPort> port);
  ~AnyClient();
  AnyClient(AnyClient&&) noexcept = default;
  AnyClient& operator=(AnyClient&& other) noexcept;

  /// As Client::call(), for messages of the service's types.
  void call(const void* request, Receiver response, double timeout,
            std::function<void()> on_timeout) const;
  /// As Client::call(), with request and response in bytes.
  void call_bytes(const std::vector<std::uint8_t>& request,
                  std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
                  std::function<void()> on_timeout) const;
  /// Whether a server was found.
  [[nodiscard]] bool ready() const;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<ClientPort> port_;
};

/// Calls a service asynchronously. The timeout of a call covers both finding a server and the
/// response.
template <class S>
class Client {
 public:
  /// The message that is sent.
  using Request = typename S::Request;
  /// The message that is returned.
  using Response = typename S::Response;

  static constexpr double kTimeout = 2.0;  ///< [s]

  Client() = default;
  /// Made by Node::create_client().
  explicit Client(AnyClient client) : client_{std::move(client)} {}

  /// Calls `fn` with the response on the node's thread. Without a response within `timeout` [s] of
  /// steady time, calls `on_timeout` instead or, if that is empty, logs a warning.
  void call(const Request& request, std::function<void(const Response&)> fn,
            double timeout = kTimeout, std::function<void()> on_timeout = {}) const {
    client_.call(&request, make_receiver<Response>(std::move(fn)), timeout, std::move(on_timeout));
  }

  /// True once a server is known.
  [[nodiscard]] bool ready() const { return client_.ready(); }

 private:
  AnyClient client_;
};

/// Calls a service whose type is known only by name; bytes are plain CDR, encapsulation included.
class GenericClient {
 public:
  GenericClient() = default;
  /// Made by Node::create_generic_client().
  explicit GenericClient(AnyClient client) : client_{std::move(client)} {}

  /// Like Client<S>::call().
  void call(const std::vector<std::uint8_t>& request,
            std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
            std::function<void()> on_timeout) const {
    client_.call_bytes(request, std::move(fn), timeout, std::move(on_timeout));
  }
  /// Whether a server was found.
  [[nodiscard]] bool ready() const { return client_.ready(); }

 private:
  AnyClient client_;
};

/// The untyped part of `Reply<S>`.
struct AnyReply {
  std::function<void(const void*)> send;  ///< sends the response at that address to the client
  PublisherId client{};                   ///< the publisher of the client's requests
};

/// Sends the response to one request of service S, now or later.
template <class S>
class Reply {
 public:
  /// Made by the service.
  explicit Reply(AnyReply reply) : reply_{std::move(reply)} {}
  /// Call once, on the node's thread. Does nothing after the service was closed.
  void send(const typename S::Response& response) const { reply_.send(&response); }
  /// The publisher of the client's requests, for Node::is_present().
  [[nodiscard]] const PublisherId& client() const { return reply_.client; }

 private:
  AnyReply reply_;
};

/// A reused request and response, and the callback that turns one into the other.
struct Responder {
  Receiver request;                       ///< deliver() fills the response
  TypeRef response_type;                  ///< of the response
  std::function<const void*()> response;  ///< the one filled in last; empty if `reply` sends it
  std::function<void(AnyReply)> reply{};  ///< called before deliver(); empty if it fills one in
};

/// A responder that calls `fn` with request and response of service S.
template <class S, class Fn>
[[nodiscard]] Responder make_responder(Fn fn) {
  using Request = typename S::Request;
  using Response = typename S::Response;
  auto response = std::make_shared<Response>();
  auto answer = [response, fn = std::move(fn)](const Request& request) mutable {
    *response = Response{};
    fn(request, *response);
  };
  return {make_receiver<Request>(std::move(answer)), type_ref<Response>(),
          [response]() -> const void* { return response.get(); }};
}

/// A responder that calls `fn` with the request of service S and the Reply that answers it.
template <class S, class Fn>
[[nodiscard]] Responder make_deferred_responder(Fn fn) {
  using Request = typename S::Request;
  auto reply = std::make_shared<AnyReply>();
  auto deliver = [reply, fn = std::move(fn)](const Request& request) mutable {
    fn(request, Reply<S>{*reply});
  };
  return {make_receiver<Request>(std::move(deliver)),
          type_ref<typename S::Response>(),
          {},
          [reply](AnyReply to) { *reply = std::move(to); }};
}

}  // namespace tandem::runtime
