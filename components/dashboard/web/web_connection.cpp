// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/web_connection.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using http_access::Response;

constexpr auto kRequestTime = std::chrono::seconds(5);  // limit for the request to arrive
constexpr auto kSilence = std::chrono::seconds(5);      // silent clients count as gone
constexpr std::size_t kLargestHead = 8192;              // [B] of an HTTP request
constexpr double kBurst = 2.0;                          // [s] of frames that may arrive at once
constexpr double kParts = 10.0;           // average parts per frame; TCP splits frames as well
constexpr double kFrameCost = 128.0;      // [B] overhead of a queued frame
constexpr double kOwnBacklog = 0.125;     // share of max_backlog for frames sent to one client only
constexpr std::size_t kPartSize = 65536;  // [B] maximum read at once

double body_size(const WebFrame& frame) {
  return frame.body ? static_cast<double>(frame.body->size()) : 0.0;
}

double own_size(const WebFrame& frame) {
  return kFrameCost + static_cast<double>(frame.head.size()) +
         (frame.shared ? 0.0 : body_size(frame));
}

double size_of(const WebFrame& frame) {
  return kFrameCost + static_cast<double>(frame.head.size()) + body_size(frame);
}

// All header fields of that name form one list.
std::string forwarded_for(const http_access::Request& request) {
  std::string all;
  const auto [begin, end] = request.equal_range("X-Forwarded-For");
  for (auto field = begin; field != end; ++field) {
    if (!all.empty()) all += ',';
    all.append(field->value().data(), field->value().size());
  }
  return all;
}

}  // namespace

WebConnection::WebConnection(WebServer::State& server, tcp::socket socket)
    : server_{server},
      tcp_{std::move(socket)},
      frames_{server.params.max_rate, kBurst * server.params.max_rate, steady_seconds()},
      parts_{kParts * server.params.max_rate, kBurst * kParts * server.params.max_rate,
             steady_seconds()} {
  tcp_.rate_policy().read_limit(static_cast<std::size_t>(1e6 * server.params.max_byte_rate));
}

WebConnection::~WebConnection() {
  server_.pool.remove(place_);
  server_.waiting.erase(place_);
  if (id_ == 0) return;
  leave();
  --server_.inside;
}

void WebConnection::start() {
  boost::system::error_code gone;
  peer_ = tcp_.socket().remote_endpoint(gone).address();
  if (gone) return;
  const bool of_proxy = is_trusted(peer_, server_.proxies);
  place_ = server_.pool.admit(of_proxy ? "" : client_address(peer_, {}, {}));
  server_.waiting[place_] = weak_from_this();
  server_.make_room();
  parser_.header_limit(kLargestHead);
  parser_.body_limit(0);
  tcp_.expires_after(kRequestTime);
  http::async_read(tcp_, buffer_, parser_, [self = shared_from_this()](auto error, auto) {
    if (!error) self->on_request();
  });
}

// Answers to one client only: a single one may be large, but few may wait.
void WebConnection::send(WebFrame frame) {
  if (over_) return;
  const double most = 1e6 * server_.params.max_backlog;
  if (own_backlog_ > kOwnBacklog * most || backlog_ + size_of(frame) > most)
    return drop("reads too slowly");
  backlog_ += size_of(frame);
  own_backlog_ += own_size(frame);
  queue_.push_back(std::move(frame));
  if (queue_.size() == 1) write();
}

void WebConnection::close() {
  boost::system::error_code ignored;
  (web_ ? beast::get_lowest_layer(*web_) : tcp_).socket().close(ignored);
}

void WebConnection::on_request() {
  const auto& request = parser_.get();
  address_ = client_address(peer_, forwarded_for(request), server_.proxies);
  server_.pool.set_address(place_, address_);
  server_.make_room();
  if (!server_.waiting.contains(place_)) return;  // it was evicted itself
  const bool wants_in = websocket::is_upgrade(request);
  const auto refusal = wants_in ? http_access::refuse(request, server_.rules()) : std::nullopt;
  if (wants_in && !refusal) return upgrade();
  if (!server_.requests.allows(address_, steady_seconds())) return put_off(1.0);
  if (refusal) return refuse(*refusal);
  reply(http_access::answer(request, server_.files));
}

void WebConnection::refuse(const http_access::Refusal& refusal) {
  server_.log("refused a web client: " + refusal.reason);
  if (refusal.wrong_token)
    if (const double wait = server_.wrong_tokens.wrong(address_, steady_seconds()); wait > 0.0)
      return put_off(wait);
  Response response{http::status::forbidden, 11};
  response.body() = refusal.reason + "\n";
  reply(std::move(response));
}

void WebConnection::put_off(double seconds) {
  Response response{http::status::too_many_requests, 11};
  response.set(http::field::retry_after, std::to_string(std::lround(std::ceil(seconds))));
  response.body() = "later\n";
  reply(std::move(response));
}

void WebConnection::reply(Response response) {
  response.set(http::field::content_length, std::to_string(response.body().size()));
  response.keep_alive(false);
  auto kept = std::make_shared<Response>(std::move(response));
  http::async_write(tcp_, *kept, [self = shared_from_this(), kept](auto, auto) {
    boost::system::error_code ignored;
    self->tcp_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  });
}

void WebConnection::upgrade() {
  server_.pool.remove(place_);
  server_.waiting.erase(place_);
  id_ = ++server_.last_client;
  ++server_.inside;
  tcp_.expires_never();
  web_.emplace(std::move(tcp_));
  web_->set_option(websocket::stream_base::timeout{kRequestTime, kSilence, true});
  web_->set_option(websocket::stream_base::decorator([this](websocket::response_type& response) {
    response.set(http::field::sec_websocket_protocol,
                 http_access::chosen_subprotocol(parser_.get(), server_.subprotocols));
  }));
  web_->read_message_max(static_cast<std::size_t>(server_.params.max_message));
  web_->control_callback(
      [this](websocket::frame_type type, beast::string_view) { on_control(type); });
  web_->async_accept(parser_.get(), [self = shared_from_this()](auto error) {
    if (!error) self->join();
  });
}

// A close frame ends the client at once, even while the reply waits behind frames that it has not
// read.
void WebConnection::on_control(websocket::frame_type type) {
  if (type != websocket::frame_type::close) {
    if (!frames_.allows(steady_seconds())) drop("pings too often");
    return;
  }
  over_ = true;
  leave();
}

void WebConnection::join() {
  boost::system::error_code ignored;  // a client may have closed already; do not throw
  beast::get_lowest_layer(*web_).socket().set_option(tcp::no_delay(true), ignored);
  server_.clients[id_] = weak_from_this();
  {
    const std::lock_guard lock{server_.queues_mutex};
    server_.queues.join(id_, steady_seconds());
  }
  buffer_.clear();
  read();
}

void WebConnection::read() {
  web_->async_read_some(buffer_, kPartSize, [self = shared_from_this()](auto error, auto) {
    if (!error) self->on_part();
  });
}

void WebConnection::on_part() {
  if (over_) return;
  if (!parts_.allows(steady_seconds())) return drop("splits frames into too many fragments");
  if (web_->is_message_done()) return on_frame();
  read();
}

void WebConnection::on_frame() {
  if (!frames_.allows(steady_seconds())) return farewell("sends too many frames at once");
  const auto kind = web_->got_text() ? WebEvent::Kind::kText : WebEvent::Kind::kBinary;
  WebEvent event{id_, kind, beast::buffers_to_string(buffer_.data())};
  buffer_.clear();
  bool taken = false;
  {
    const std::lock_guard lock{server_.queues_mutex};
    taken = server_.queues.push(std::move(event));
  }
  if (!taken) return farewell("sends more requests than can be served");
  read();
}

void WebConnection::write() {
  const WebFrame& frame = queue_.front();
  web_->text(frame.text);
  std::array<asio::const_buffer, 2> parts{asio::buffer(frame.head), asio::const_buffer{}};
  if (frame.body) parts[1] = asio::buffer(*frame.body);
  web_->async_write(parts, [self = shared_from_this()](auto error, auto) {
    if (error) return;
    self->backlog_ -= size_of(self->queue_.front());
    self->own_backlog_ -= own_size(self->queue_.front());
    self->queue_.pop_front();
    if (!self->queue_.empty() && !self->over_) self->write();
  });
}

void WebConnection::leave() {
  server_.clients.erase(id_);
  const std::lock_guard lock{server_.queues_mutex};
  server_.queues.leave(id_);
}

// No close frame: a client that is too slow for the robot's state is too slow for that, too.
void WebConnection::drop(const std::string& why) {
  if (std::exchange(over_, true)) return;
  server_.log("web client " + std::to_string(id_) + " " + why + ": disconnected");
  leave();
  close();
}

// The client is removed immediately; the connection ends when it answers, or after kRequestTime.
void WebConnection::farewell(const std::string& why) {
  if (std::exchange(over_, true)) return;
  server_.log("web client " + std::to_string(id_) + " " + why + ": disconnected");
  leave();
  const websocket::close_reason reason{websocket::close_code::policy_error, "this client " + why};
  web_->async_close(reason, [self = shared_from_this()](auto) { self->close(); });
}

}  // namespace tandem
