// SPDX-License-Identifier: Apache-2.0
// State shared by the connections of a WebServer. Everything but the queues is used on the server's
// thread only.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "tandem/dashboard/web/client_address.hpp"
#include "tandem/dashboard/web/client_queues.hpp"
#include "tandem/dashboard/web/connection_pool.hpp"
#include "tandem/dashboard/web/http_access.hpp"
#include "tandem/dashboard/web/request_limit.hpp"
#include "tandem/dashboard/web/token_delay.hpp"
#include "tandem/dashboard/web/web_server.hpp"

namespace tandem {

class WebConnection;

/// Time [s] on the clock that all limits of the server use.
[[nodiscard]] inline double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct WebServer::State {
  State(const WebServerParams& wanted, std::vector<std::string> protocols,
        std::map<std::string, WebFile> pages, Log logger);

  void listen();
  void accept();
  void accept_after(std::chrono::milliseconds time);
  /// Closes connections until the pool is within its limits again.
  void make_room();
  [[nodiscard]] http_access::Rules rules() const {
    return {params, subprotocols, token, loopback, inside};
  }

  const WebServerParams params;
  const std::vector<std::string> subprotocols;
  const std::map<std::string, WebFile> files;
  const Log log;
  const TrustedProxies proxies;

  std::string token;
  bool loopback = true;  // only programs on this machine can connect
  int port = 0;
  int inside = 0;  // connections that became clients and are still open
  ClientId last_client = 0;
  std::map<ClientId, std::weak_ptr<WebConnection>> clients;
  std::map<ConnectionPool::Id, std::weak_ptr<WebConnection>> waiting;
  ConnectionPool pool{{}};
  RateLimit accepts;
  RequestLimit requests;
  TokenDelay wrong_tokens;

  std::mutex queues_mutex;
  ClientQueues queues;

  boost::asio::io_context io{1};  // declared after what connections use, because it destroys them
  boost::asio::ip::tcp::acceptor acceptor{io};
  boost::asio::steady_timer pause{io};

  std::thread thread;
};

}  // namespace tandem
