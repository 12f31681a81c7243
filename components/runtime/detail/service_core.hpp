// SPDX-License-Identifier: Apache-2.0
// Implements service servers and clients; replies are correlated by DDS sample identity, as in
// rmw_fastrtps. Private to runtime/.
#pragma once

#include <deque>
#include <map>
#include <memory>

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

/// Answers requests. A reply is queued until the client's reader is matched. If the client does not
/// identify its reader, the reply is sent again for each reader that its participant adds within
/// the waiting time, because the readers matched so far may belong to other clients.
class Server {
 public:
  // ROS 2's services profile with a deeper queue, because an evicted request is lost for good.
  static constexpr QoS kQueue{.depth = 100};

  Server(NodeCore& node, const std::string& service, Responder responder, QoS qos = kQueue);
  void close();

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
  double send_replies(double now);
  void send(QueuedReply& reply);

  NodeCore& node_;
  std::string service_;
  Responder responder_;
  Codec request_codec_, response_codec_;
  std::deque<QueuedReply> replies_;
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
  std::shared_ptr<Server*> self_ = std::make_shared<Server*>(this);  // until it is closed
};

/// Sends requests and completes each call with a response or a timeout. Requests are queued until a
/// server is matched.
class Caller {
 public:
  /// Returns false for bytes that do not decode; the call then keeps waiting for a valid response.
  using OnResponse = std::function<bool(const Bytes&)>;

  /// Types are given by their DDS names.
  Caller(NodeCore& node, const std::string& service, const std::string& request_type,
         const std::string& response_type);
  /// An empty request means that encoding failed; the call then fails.
  void call(Bytes request, OnResponse on_response, double timeout,
            std::function<void()> on_timeout);
  [[nodiscard]] bool ready() const;
  void close();

 private:
  struct Call {
    Bytes request;
    OnResponse on_response;
    double deadline;  // [s], steady clock
    std::function<void()> on_timeout;
  };

  bool on_response(const Bytes& bytes, const fdds::SampleInfo& info);
  double poll(double now);
  void send_waiting();
  void expire(double now);
  void fail(const Call& call);

  NodeCore& node_;
  std::string service_;
  std::deque<Call> waiting_;            // not sent yet
  std::map<std::int64_t, Call> asked_;  // sent; key: sequence number
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

}  // namespace tandem::runtime
