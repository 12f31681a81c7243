// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/service_core.hpp"

#include <algorithm>
#include <limits>

#include "tandem/runtime/detail/reader_set.hpp"

namespace tandem::runtime {
namespace {

constexpr double kNoDeadline = std::numeric_limits<double>::infinity();
constexpr double kMatchWait = 1.0;       // maximum wait of a reply for the client's reader [s]
constexpr double kRetry = 0.005;         // [s] between checks for matched endpoints
constexpr std::size_t kMaxQueue = 1000;  // maximum number of pending replies and of waiting calls

std::int64_t number_of(const rtps::SampleIdentity& identity) {
  const auto& number = identity.sequence_number();
  return (std::int64_t{number.high} << 32) | number.low;
}

bool known(const rtps::GUID_t& guid) { return guid != rtps::GUID_t::unknown(); }

}  // namespace

Server::Server(DdsNode& node, const std::string& service, Responder responder, const QoS& qos,
               std::shared_ptr<ServiceEvents> events)
    : node_{node},
      service_{service},
      responder_{std::move(responder)},
      events_{std::move(events)},
      request_codec_{responder_.request.type},
      response_codec_{responder_.response_type},
      writer_{node.open_writer({dds_reply_name(service), response_codec_.dds_name(), qos})},
      reader_{node.open_reader(
          {dds_request_name(service), request_codec_.dds_name(), qos},
          [this](const Bytes& bytes, const auto& info) { return on_request(bytes, info); })},
      poller_{std::make_shared<Poller>()} {
  poller_->poll = [this](double now) { return send_replies(now); };
  node.add(poller_);
}

void Server::close() {
  self_.reset();
  if (events_) events_->close();
  events_.reset();
  node_.remove(*poller_);
  node_.close_reader(*reader_);
  node_.close_writer(*writer_);
}

bool Server::on_request(const Bytes& bytes, const fdds::SampleInfo& info) {
  if (!request_codec_.decode(bytes, responder_.request.message())) {
    responder_.request.reset();
    return false;
  }
  rtps::SampleIdentity to = info.sample_identity;
  const auto& client = info.related_sample_identity.writer_guid();
  if (known(client)) to.writer_guid(client);
  tell(ServiceEvent::kRequestReceived, to, bytes);
  if (responder_.reply) responder_.reply(reply_to(to, info.sample_identity.writer_guid()));
  responder_.request.deliver(responder_.request.message());
  if (!responder_.reply) respond(to, responder_.response());
  return true;
}

AnyReply Server::reply_to(const rtps::SampleIdentity& to, const rtps::GUID_t& client) {
  const auto send = [self = std::weak_ptr{self_}, to](const void* response) {
    if (const auto server = self.lock()) (*server)->respond(to, response);
  };
  return {send, to_id(client)};
}

void Server::respond(const rtps::SampleIdentity& to, const void* response) {
  QueuedReply reply{{}, to, steady_seconds() + kMatchWait};
  if (!response_codec_.encode(response, reply.bytes)) {
    node_.log.error("{}: the response could not be sent", service_);
  } else if (replies_.size() < kMaxQueue) {
    tell(ServiceEvent::kResponseSent, to, reply.bytes);
    replies_.push_back(std::move(reply));
  }
  poller_->next = 0.0;
}

void Server::tell(ServiceEvent event, const rtps::SampleIdentity& request, const Bytes& contents) {
  if (events_) events_->publish(event, to_id(request.writer_guid()), number_of(request), contents);
}

double Server::send_replies(double now) {
  for (QueuedReply& reply : replies_) send(reply);
  std::erase_if(replies_, [now](const QueuedReply& reply) {
    const bool is_reachable = reply.reached > 0 && reply.to.writer_guid().entityId.is_reader();
    return is_reachable || now >= reply.deadline;  // a client that has left would not receive it
  });
  return replies_.empty() ? kNoDeadline : now + kRetry;
}

void Server::send(QueuedReply& reply) {
  const auto latest = writer_->matched_at(reply.to.writer_guid());
  if (latest <= reply.reached) return;
  reply.reached = latest;
  rtps::WriteParams params;
  params.related_sample_identity(reply.to);
  if (!writer_->write(reply.bytes, params))
    node_.log.warn_every(1.0, "{}: a response could not be sent", service_);
}

Caller::Caller(DdsNode& node, const std::string& service, const std::string& request_type,
               const std::string& response_type, std::shared_ptr<ServiceEvents> events)
    : node_{node},
      service_{service},
      events_{std::move(events)},
      writer_{node.open_writer({dds_request_name(service), request_type, kRequestQueue})},
      reader_{node.open_reader(
          {dds_reply_name(service), response_type, kRequestQueue},
          [this](const Bytes& bytes, const auto& info) { return on_response(bytes, info); })},
      poller_{std::make_shared<Poller>()} {
  poller_->poll = [this](double now) { return poll(now); };
  node.add(poller_);
}

void Caller::close() {
  events_->close();
  events_.reset();
  node_.remove(*poller_);
  node_.close_reader(*reader_);
  node_.close_writer(*writer_);
}

bool Caller::ready() const { return writer_->matched() > 0 && reader_->matched() > 0; }

Caller::Caller(DdsNode& node, const std::string& service, TypeRef request, TypeRef response,
               std::shared_ptr<ServiceEvents> events)
    : Caller{node, service, Codec{request}.dds_name(), Codec{response}.dds_name(),
             std::move(events)} {
  request_codec_.emplace(request);
  response_codec_ = std::make_shared<Codec>(response);
}

void Caller::call(const void* request, Receiver response, double timeout,
                  std::function<void()> on_timeout) {
  Bytes bytes;
  if (!request_codec_->encode(request, bytes)) bytes.clear();
  auto deliver = [codec = response_codec_, response = std::move(response)](const Bytes& answer) {
    if (!codec->decode(answer, response.message())) return false;
    response.deliver(response.message());
    return true;
  };
  send(std::move(bytes), std::move(deliver), timeout, std::move(on_timeout));
}

void Caller::call_bytes(const Bytes& request, std::function<void(const Bytes&)> fn, double timeout,
                        std::function<void()> on_timeout) {
  auto deliver = [fn = std::move(fn)](const Bytes& answer) {
    fn(answer);
    return true;
  };
  send(request, std::move(deliver), timeout, std::move(on_timeout));
}

void Caller::send(Bytes request, OnResponse on_response, double timeout,
                  std::function<void()> on_timeout) {
  Call call{std::move(request), std::move(on_response), steady_seconds() + timeout,
            std::move(on_timeout)};
  if (call.request.empty() || waiting_.size() >= kMaxQueue)
    call.deadline = 0.0;  // fails at the next poll, not inside call()
  waiting_.push_back(std::move(call));
  poller_->next = 0.0;
}

double Caller::poll(double now) {
  expire(now);
  if (!waiting_.empty() && ready()) send_waiting();
  if (!waiting_.empty()) return now + kRetry;
  double next = kNoDeadline;
  for (const auto& [number, call] : asked_) next = std::min(next, call.deadline);
  return next;
}

void Caller::send_waiting() {
  for (; !waiting_.empty() && std::ssize(asked_) < kRequestQueue.depth; waiting_.pop_front()) {
    rtps::WriteParams params;
    params.related_sample_identity().writer_guid(reader_->guid());
    if (!writer_->write(waiting_.front().request, params)) return;
    events_->publish(ServiceEvent::kRequestSent, to_id(writer_->guid()),
                     number_of(params.sample_identity()), waiting_.front().request);
    asked_.emplace(number_of(params.sample_identity()), std::move(waiting_.front()));
  }
}

void Caller::expire(double now) {
  std::vector<Call> expired;  // collected first, because on_timeout may call again
  std::erase_if(waiting_, [&](Call& call) {
    const bool over = now >= call.deadline;
    if (over) expired.push_back(std::move(call));
    return over;
  });
  std::erase_if(asked_, [&](auto& entry) {
    const bool over = now >= entry.second.deadline;
    if (over) expired.push_back(std::move(entry.second));
    return over;
  });
  for (const auto& call : expired) fail(call);
}

void Caller::fail(const Call& call) {
  if (call.on_timeout)
    call.on_timeout();
  else
    node_.log.warn("{}: no answer in time", service_);
}

bool Caller::on_response(const Bytes& bytes, const fdds::SampleInfo& info) {
  const auto& to = info.related_sample_identity;
  if (to.writer_guid() != reader_->guid() && to.writer_guid() != writer_->guid()) return true;
  auto call = asked_.extract(number_of(to));
  if (call.empty()) return true;  // after the timeout
  events_->publish(ServiceEvent::kResponseReceived, to_id(writer_->guid()), number_of(to), bytes);
  if (call.mapped().on_response(bytes)) return true;
  asked_.insert(std::move(call));  // a valid response may still follow
  return false;
}

}  // namespace tandem::runtime
