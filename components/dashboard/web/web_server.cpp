// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/web_server.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/post.hpp>

#include "tandem/dashboard/web/access_token.hpp"
#include "tandem/dashboard/web/web_connection.hpp"
#include "tandem/dashboard/web/web_server_state.hpp"

namespace tandem {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;

constexpr auto kPause = std::chrono::milliseconds(100);      // after a failed accept
constexpr double kAccepts = 2000.0, kAcceptsAtOnce = 200.0;  // [Hz], burst of accepts
constexpr auto kAcceptPause = std::chrono::milliseconds(1);
constexpr double kQueue = 4.0;  // [s] of frames at max_rate that a client's queue holds

// At least as much as the other limits allow at once.
ClientQueues::Limits queue_limits(const WebServerParams& params) {
  ClientQueues::Limits limits;
  limits.frames = std::max(limits.frames, static_cast<std::size_t>(kQueue * params.max_rate));
  limits.bytes = std::max(limits.bytes, 4 * static_cast<std::size_t>(params.max_message));
  return limits;
}

// Address of this machine in the network; phones usually cannot resolve its name.
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

WebServer::State::State(const WebServerParams& wanted, std::vector<std::string> protocols,
                        std::map<std::string, WebFile> pages, Log logger)
    : params{wanted},
      subprotocols{std::move(protocols)},
      files{std::move(pages)},
      log{std::move(logger)},
      proxies{trusted_proxies(wanted.trusted_proxies)},
      accepts{kAccepts, kAcceptsAtOnce, steady_seconds()},
      queues{queue_limits(wanted)} {}

void WebServer::State::listen() {
  acceptor = http_access::listen(io, params);
  const auto endpoint = acceptor.local_endpoint();
  // Connections through a proxy may come from anywhere.
  loopback = endpoint.address().is_loopback() && proxies.empty();
  if (!params.token_file.empty())
    token = token_from(params.token_file);
  else if (!loopback)
    token = new_token();
  port = endpoint.port();
  accept();
}

// At most kAccepts per second: connections that are renewed faster than a request takes to arrive
// would evict each other. A connection that waits in the kernel has its request ready when it is
// accepted.
void WebServer::State::accept() {
  acceptor.async_accept([this](auto error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) return accept_after(kPause);  // probably out of file descriptors
    std::make_shared<WebConnection>(*this, std::move(socket))->start();
    if (accepts.allows(steady_seconds())) return accept();
    accept_after(kAcceptPause);
  });
}

void WebServer::State::accept_after(std::chrono::milliseconds time) {
  pause.expires_after(time);
  pause.async_wait([this](auto error) {
    if (!error) accept();
  });
}

void WebServer::State::make_room() {
  while (const auto id = pool.evict()) {
    const auto found = waiting.find(*id);
    if (found == waiting.end()) continue;
    const auto connection = found->second.lock();
    waiting.erase(found);
    if (connection) connection->close();
  }
}

WebServer::WebServer(const WebServerParams& params, std::vector<std::string> subprotocols,
                     std::map<std::string, WebFile> files, Log log)
    : state_{std::make_unique<State>(params, std::move(subprotocols), std::move(files),
                                     std::move(log))} {
  state_->listen();
  state_->thread = std::thread{[this] { state_->io.run(); }};
}

WebServer::~WebServer() {
  state_->io.stop();
  state_->thread.join();
}

std::optional<WebEvent> WebServer::next(Lane lane) {
  const std::lock_guard lock{state_->queues_mutex};
  return state_->queues.next(lane, steady_seconds());
}

void WebServer::charge(ClientId client, double work) {
  const std::lock_guard lock{state_->queues_mutex};
  state_->queues.charge(client, work, steady_seconds());
}

void WebServer::set_urgent(ClientId client, std::vector<std::string> prefixes) {
  const std::lock_guard lock{state_->queues_mutex};
  state_->queues.set_urgent(client, std::move(prefixes));
}

void WebServer::send(ClientId client, WebFrame frame) {
  asio::post(state_->io, [state = state_.get(), client, frame = std::move(frame)]() mutable {
    const auto found = state->clients.find(client);
    if (found == state->clients.end()) return;
    if (const auto connection = found->second.lock()) connection->send(std::move(frame));
  });
}

void WebServer::answer(ClientId client, WebFrame frame) {
  const std::size_t bytes = frame.head.size() + (frame.body ? frame.body->size() : 0);
  charge(client, kCostPerByte * static_cast<double>(bytes));
  send(client, std::move(frame));
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
