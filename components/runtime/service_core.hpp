// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: both ends of a service, correlated by DDS sample identity as rmw_fastrtps
// does.
#pragma once

#include <deque>
#include <map>
#include <memory>

#include "runtime/node_core.hpp"

namespace tandem::runtime {

/// Answers requests. A reply waits, off the loop, until the asking client's reader is matched.
class Server {
 public:
  Server(NodeCore& node, const std::string& service, Responder responder);
  void close();

 private:
  struct Reply {
    Bytes bytes;
    rtps::SampleIdentity to;
    double deadline;  // [s] steady: then it goes out, matched or not
  };

  bool on_request(const Bytes& bytes, const fdds::SampleInfo& info);
  double send_replies(double now);
  void send(const Reply& reply);

  NodeCore& node_;
  std::string service_;
  Responder responder_;
  Codec request_codec_, response_codec_;
  std::deque<Reply> replies_;
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

/// Asks, and gives each call its answer or its timeout. Requests wait for the server.
class Caller {
 public:
  Caller(NodeCore& node, const std::string& service, TypeRef request, TypeRef response);
  void call(const void* request, Receiver response, double timeout,
            std::function<void()> on_timeout);
  [[nodiscard]] bool ready() const;
  void close();

 private:
  struct Call {
    Bytes request;
    Receiver response;
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
  Codec request_codec_, response_codec_;
  std::deque<Call> waiting_;            // for the server
  std::map<std::int64_t, Call> asked_;  // by sequence number
  std::shared_ptr<Writer> writer_;
  std::shared_ptr<Reader> reader_;
  std::shared_ptr<Poller> poller_;
};

}  // namespace tandem::runtime
