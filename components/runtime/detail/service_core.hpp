// SPDX-License-Identifier: Apache-2.0
// Implements service servers and clients; replies are correlated by DDS sample identity, as in
// rmw_fastrtps. Private to runtime/.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "tandem/runtime/detail/dds_node.hpp"

namespace tandem::runtime {

/// Answers requests. A reply is queued until the client's reader is matched. If the client does not
/// identify its reader, the reply is sent again for each reader that its participant adds within
/// the waiting time, because the readers matched so far may belong to other clients.
class Server final : public ServicePort {
 public:
  Server(DdsNode& node, const std::string& service, Responder responder, const QoS& qos,
         std::shared_ptr<ServiceEvents> events);
  void close() override;

 private:
  struct QueuedReply {
    Bytes bytes;
    rtps::SampleIdentity to;
    double deadline;           // dropped after this time [s], steady clock
    Writer::Turn reached = 0;  // the latest reader it was sent to
  };

  bool on_request(const Bytes& bytes, const fdds::SampleInfo& info);
  [[nodiscard]] AnyReply reply_to(const rtps::SampleIdentity& to, const rtps::GUID_t& client);
  void respond(const rtps::SampleIdentity& to, const void* response);
  void tell(ServiceEvent event, const rtps::SampleIdentity& request, const Bytes& contents);
  double send_replies(double now);
  void send(QueuedReply& reply);

  DdsNode& node_;
  std::string service_;
  Responder responder_;
  std::shared_ptr<ServiceEvents> events_;  // null: none are published, or closed
  Codec request_codec_, response_codec_;
  std::deque<QueuedReply> replies_;
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
  std::shared_ptr<Server*> self_ = std::make_shared<Server*>(this);  // until it is closed
};

/// Sends requests and completes each call with a response or a timeout. Requests are queued until a
/// server is matched.
class Caller final : public ClientPort {
 public:
  Caller(DdsNode& node, const std::string& service, TypeRef request, TypeRef response,
         std::shared_ptr<ServiceEvents> events);
  /// For requests and responses in bytes only. Types are given by their DDS names.
  Caller(DdsNode& node, const std::string& service, const std::string& request_type,
         const std::string& response_type, std::shared_ptr<ServiceEvents> events);

  void call(const void* request, Receiver response, double timeout,
            std::function<void()> on_timeout) override;
  void call_bytes(const Bytes& request, std::function<void(const Bytes&)> fn, double timeout,
                  std::function<void()> on_timeout) override;
  [[nodiscard]] bool ready() const override;
  void close() override;

 private:
  // Returns false for bytes that do not decode; the call then keeps waiting for a valid response.
  using OnResponse = std::function<bool(const Bytes&)>;
  struct Call {
    Bytes request;
    OnResponse on_response;
    double deadline;  // [s], steady clock
    std::function<void()> on_timeout;
  };

  // An empty request means that encoding failed; the call then fails.
  void send(Bytes request, OnResponse on_response, double timeout,
            std::function<void()> on_timeout);
  bool on_response(const Bytes& bytes, const fdds::SampleInfo& info);
  double poll(double now);
  void send_waiting();
  void expire(double now);
  void fail(const Call& call);

  DdsNode& node_;
  std::string service_;
  std::shared_ptr<ServiceEvents> events_;
  std::deque<Call> waiting_;            // not sent yet
  std::map<std::int64_t, Call> asked_;  // sent; key: sequence number
  std::optional<Codec> request_codec_;
  std::shared_ptr<Codec> response_codec_;
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

}  // namespace tandem::runtime
