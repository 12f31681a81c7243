// SPDX-License-Identifier: Apache-2.0
// One TCP connection of the web server: an HTTP request that may be upgraded to a WebSocket.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "tandem/dashboard/web/client_budget.hpp"
#include "tandem/dashboard/web/web_server_state.hpp"

namespace tandem {

class WebConnection : public std::enable_shared_from_this<WebConnection> {
 public:
  WebConnection(WebServer::State& server, boost::asio::ip::tcp::socket socket);
  ~WebConnection();
  WebConnection(const WebConnection&) = delete;
  WebConnection& operator=(const WebConnection&) = delete;

  void start();
  void send(WebFrame frame);
  /// Closes immediately, without a close frame.
  void close();

 private:
  // Limits the bytes read per second; the rest waits in the socket.
  using Stream = boost::beast::basic_stream<boost::asio::ip::tcp, boost::asio::any_io_executor,
                                            boost::beast::simple_rate_policy>;

  void on_request();
  void refuse(const http_access::Refusal& refusal);
  void put_off(double seconds);
  void reply(http_access::Response response);
  void upgrade();
  void on_control(boost::beast::websocket::frame_type type);
  void join();
  void read();
  void on_part();
  void on_frame();
  void write();
  void leave();
  void drop(const std::string& why);
  void farewell(const std::string& why);

  WebServer::State& server_;
  Stream tcp_;
  boost::asio::ip::address peer_;
  std::string address_;  // the address that limits apply to
  ConnectionPool::Id place_ = 0;
  boost::beast::http::request_parser<boost::beast::http::empty_body> parser_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::websocket::stream<Stream>> web_;
  ClientId id_ = 0;  // 0: not a client yet
  RateLimit frames_, parts_;
  std::deque<WebFrame> queue_;
  double backlog_ = 0.0, own_backlog_ = 0.0;  // [B] in the queue; of unshared frames
  bool over_ = false;
};

}  // namespace tandem
