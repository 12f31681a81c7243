// SPDX-License-Identifier: Apache-2.0
#include "dashboard/web_server.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "dashboard/access_token.hpp"
#include "dashboard/web_door.hpp"

namespace tandem {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Response = web_door::Response;
using Steady = std::chrono::steady_clock;

constexpr auto kRequestTime = std::chrono::seconds(5);   // to say what it wants
constexpr auto kSilence = std::chrono::seconds(5);       // without a sign of life: gone
constexpr auto kPause = std::chrono::milliseconds(100);  // after an accept that failed
constexpr std::size_t kLargestHead = 8192;               // [B] of an HTTP request
constexpr std::size_t kMaxEvents = 20'000;               // that nobody took
constexpr double kBurst = 2.0;                           // [s] of frames at once

// Frames of one client: so many a second, twice as many at once.
class RateLimit {
 public:
  explicit RateLimit(double rate) : rate_{rate}, left_{kBurst * rate} {}
  [[nodiscard]] bool allows() {
    const auto now = Steady::now();
    left_ = std::min(kBurst * rate_,
                     left_ + rate_ * std::chrono::duration<double>(now - last_).count());
    last_ = now;
    return --left_ >= 0.0;
  }

 private:
  double rate_, left_;
  Steady::time_point last_ = Steady::now();
};

// Where others of the network find this machine; a phone seldom knows its name.
std::string own_address() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return asio::ip::host_name();
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner{all, &freeifaddrs};
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    const bool usable = (at->ifa_flags & IFF_UP) != 0 && (at->ifa_flags & IFF_LOOPBACK) == 0;
    if (!usable || at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN];
    const auto* address = reinterpret_cast<const sockaddr_in*>(at->ifa_addr);
    if (inet_ntop(AF_INET, &address->sin_addr, text, sizeof text) != nullptr) return text;
  }
  return asio::ip::host_name();
}

}  // namespace

struct WebServer::State {
  State(const WebServerParams& wanted, std::string protocol, std::map<std::string, WebFile> pages,
        Log logger)
      : params{wanted},
        subprotocol{std::move(protocol)},
        files{std::move(pages)},
        log{std::move(logger)} {}

  void listen();
  void accept();
  void report(WebEvent event);
  [[nodiscard]] web_door::Rules rules() const {
    return {params, subprotocol, token, loopback, static_cast<int>(clients.size())};
  }

  class Connection;

  const WebServerParams params;
  const std::string subprotocol;
  const std::map<std::string, WebFile> files;
  const Log log;

  std::string token;
  bool loopback = true;
  int port = 0;
  std::map<ClientId, std::weak_ptr<Connection>> clients;
  int connections = 0;
  ClientId last_client = 0;

  std::mutex events_mutex;
  std::vector<WebEvent> events;

  asio::io_context io{1};  // after what connections refer to: they die with it
  tcp::acceptor acceptor{io};
  asio::steady_timer pause{io};

  std::thread thread;
};

// One TCP connection: an HTTP request, and then perhaps a WebSocket.
class WebServer::State::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(State& server, tcp::socket socket)
      : server_{server}, tcp_{std::move(socket)}, rate_{server.params.max_rate} {
    ++server_.connections;
  }
  ~Connection() {
    --server_.connections;
    if (id_ == 0) return;
    server_.clients.erase(id_);
    server_.report({id_, WebEvent::Kind::kLeft, {}});
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start() {
    parser_.header_limit(kLargestHead);
    parser_.body_limit(0);
    tcp_.expires_after(kRequestTime);
    http::async_read(tcp_, buffer_, parser_, [self = shared_from_this()](auto error, auto) {
      if (!error) self->on_request();
    });
  }

  void send(WebFrame frame) {
    backlog_ += size_of(frame);
    if (backlog_ > 1e6 * server_.params.max_backlog) {
      drop("is too slow");
      return;
    }
    queue_.push_back(std::move(frame));
    if (queue_.size() == 1) write();
  }

 private:
  static double size_of(const WebFrame& frame) {
    return static_cast<double>(frame.head.size() + (frame.body ? frame.body->size() : 0));
  }

  void on_request() {
    if (!websocket::is_upgrade(parser_.get())) {
      reply(web_door::answer(parser_.get(), server_.files));
      return;
    }
    if (const auto reason = web_door::refuse(parser_.get(), server_.rules())) {
      server_.log("a web client is refused: " + *reason);
      Response response{http::status::forbidden, 11};
      response.body() = *reason + "\n";
      reply(std::move(response));
      return;
    }
    upgrade();
  }

  void reply(Response response) {
    response.set(http::field::content_length, std::to_string(response.body().size()));
    response.keep_alive(false);
    auto kept = std::make_shared<Response>(std::move(response));
    http::async_write(tcp_, *kept, [self = shared_from_this(), kept](auto, auto) {
      boost::system::error_code ignored;
      self->tcp_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  void upgrade() {
    tcp_.expires_never();
    web_.emplace(std::move(tcp_));
    web_->set_option(websocket::stream_base::timeout{kRequestTime, kSilence, true});
    web_->set_option(websocket::stream_base::decorator([this](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, server_.subprotocol);
    }));
    web_->read_message_max(static_cast<std::size_t>(server_.params.max_message));
    web_->async_accept(parser_.get(), [self = shared_from_this()](auto error) {
      if (!error) self->join();
    });
  }

  void join() {
    boost::system::error_code ignored;  // a client that is gone again must not throw here
    beast::get_lowest_layer(*web_).socket().set_option(tcp::no_delay(true), ignored);
    id_ = ++server_.last_client;
    server_.clients[id_] = weak_from_this();
    server_.report({id_, WebEvent::Kind::kJoined, {}});
    buffer_.clear();
    read();
  }

  void read() {
    web_->async_read(buffer_, [self = shared_from_this()](auto error, auto) {
      if (!error) self->on_frame();
    });
  }

  void on_frame() {
    if (!rate_.allows()) {
      drop("says too much at once");
      return;
    }
    const auto kind = web_->got_text() ? WebEvent::Kind::kText : WebEvent::Kind::kBinary;
    server_.report({id_, kind, beast::buffers_to_string(buffer_.data())});
    buffer_.clear();
    read();
  }

  void write() {
    const WebFrame& frame = queue_.front();
    web_->text(frame.text);
    std::array<asio::const_buffer, 2> parts{asio::buffer(frame.head), asio::const_buffer{}};
    if (frame.body) parts[1] = asio::buffer(*frame.body);
    web_->async_write(parts, [self = shared_from_this()](auto error, auto) {
      if (error) return;
      self->backlog_ -= size_of(self->queue_.front());
      self->queue_.pop_front();
      if (!self->queue_.empty()) self->write();
    });
  }

  // No farewell: what is too slow to be told the robot's state is too slow for that.
  void drop(const std::string& why) {
    if (dropped_) return;
    dropped_ = true;
    server_.log("web client " + std::to_string(id_) + " " + why + ": dropped");
    boost::system::error_code ignored;
    beast::get_lowest_layer(*web_).socket().close(ignored);
  }

  State& server_;
  beast::tcp_stream tcp_;
  http::request_parser<http::empty_body> parser_;
  beast::flat_buffer buffer_;
  std::optional<websocket::stream<beast::tcp_stream>> web_;
  ClientId id_ = 0;  // 0: no WebSocket yet
  RateLimit rate_;
  std::deque<WebFrame> queue_;
  double backlog_ = 0.0;  // [B]
  bool dropped_ = false;
};

void WebServer::State::listen() {
  acceptor = web_door::listen(io, params);
  const auto endpoint = acceptor.local_endpoint();
  loopback = endpoint.address().is_loopback();
  if (!params.token_file.empty())
    token = token_from(params.token_file);
  else if (!loopback)
    token = new_token();
  port = endpoint.port();
  accept();
}

void WebServer::State::accept() {
  acceptor.async_accept([this](auto error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // out of files, most likely
      pause.expires_after(kPause);
      pause.async_wait([this](auto) { accept(); });
      return;
    }
    // Twice: who only fetches a file needs a place for a moment.
    if (connections < 2 * params.max_clients)
      std::make_shared<Connection>(*this, std::move(socket))->start();
    accept();
  });
}

void WebServer::State::report(WebEvent event) {
  const std::lock_guard lock{events_mutex};
  // Comings and goings are few and never lost.
  const bool frame = event.kind == WebEvent::Kind::kText || event.kind == WebEvent::Kind::kBinary;
  if (!frame || events.size() < kMaxEvents) events.push_back(std::move(event));
}

WebServer::WebServer(const WebServerParams& params, std::string subprotocol,
                     std::map<std::string, WebFile> files, Log log)
    : state_{std::make_unique<State>(params, std::move(subprotocol), std::move(files),
                                     std::move(log))} {
  state_->listen();
  state_->thread = std::thread{[this] { state_->io.run(); }};
}

WebServer::~WebServer() {
  state_->io.stop();
  state_->thread.join();
}

std::vector<WebEvent> WebServer::take() {
  const std::lock_guard lock{state_->events_mutex};
  return std::exchange(state_->events, {});
}

void WebServer::send(ClientId client, WebFrame frame) {
  asio::post(state_->io, [state = state_.get(), client, frame = std::move(frame)]() mutable {
    const auto found = state->clients.find(client);
    if (found == state->clients.end()) return;
    if (const auto connection = found->second.lock()) connection->send(std::move(frame));
  });
}

int WebServer::port() const { return state_->port; }

const std::string& WebServer::token() const { return state_->token; }

std::string WebServer::url() const {
  const auto& params = state_->params;
  std::string host =
      params.address.find(':') == std::string::npos ? params.address : "[" + params.address + "]";
  if (params.address == "0.0.0.0" || params.address == "::") host = own_address();
  return "http://" + host + ":" + std::to_string(port()) + "/";
}

}  // namespace tandem
