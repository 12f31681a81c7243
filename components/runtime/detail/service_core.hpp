// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: both ends of a service, correlated by DDS sample identity as rmw_fastrtps
// does.
#pragma once

#include <deque>
#include <map>
#include <memory>

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

/// Answers requests. A reply waits, off the loop, until the asking client's reader is matched. A
/// client that does not tell which reader that is gets it again for each that its participant adds
/// within that time: another client's may have been there already.
class Server {
 public:
  // ROS 2's profile, but longer: a request that the queue pushes out would be lost for good.
  static constexpr QoS kQueue{.depth = 100};

  Server(NodeCore& node, const std::string& service, Responder responder, QoS qos = kQueue);
  void close();

 private:
  struct Reply {
    Bytes bytes;
    rtps::SampleIdentity to;
    double deadline;           // [s] steady: then it is dropped
    Writer::Turn reached = 0;  // the latest reader that it was sent to
  };

  bool on_request(const Bytes& bytes, const fdds::SampleInfo& info);
  double send_replies(double now);
  void send(Reply& reply);

  NodeCore& node_;
  std::string service_;
  Responder responder_;
  Codec request_codec_, response_codec_;
  std::deque<Reply> replies_;
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

/// Sends requests and completes each call with a response or a timeout. Requests are queued until a
/// server is matched.
class Caller {
 public:
  /// Returns false for bytes that do not decode; the call then keeps waiting for a valid response.
  using OnResponse = std::function<bool(const Bytes&)>;

  /// Types by their DDS names.
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
    double deadline;  // [s] steady
    std::function<void()> on_timeout;
  };

  bool on_response(const Bytes& bytes, const fdds::SampleInfo& info);
  double poll(double now);
  void send_waiting();
  void expire(double now);
  void fail(const Call& call);

  NodeCore& node_;
  std::string service_;
  std::deque<Call> waiting_;            // for the server
  std::map<std::int64_t, Call> asked_;  // by sequence number
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

}  // namespace tandem::runtime
