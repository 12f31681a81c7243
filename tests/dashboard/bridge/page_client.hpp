// SPDX-License-Identifier: Apache-2.0
// A web server with one client, for tests of the relays' answers.
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <stdexcept>
#include <string>
#include <utility>

#include "support/spin_until.hpp"
#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::test {

/// Connects on construction.
class PageClient {
 public:
  PageClient() {
    namespace websocket = boost::beast::websocket;
    stream_.next_layer().connect(
        {boost::asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(web_.port())});
    stream_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
      request.set(boost::beast::http::field::sec_websocket_protocol,
                  foxglove::kSubprotocols.front());
    }));
    stream_.handshake("127.0.0.1:" + std::to_string(web_.port()), "/");
    for (const double end = rt::steady_seconds() + kTimeout; rt::steady_seconds() < end;)
      if (const auto joined = web_.next(Lane::kJoined)) {
        id_ = joined->client;
        return;
      }
    ADD_FAILURE() << "the server did not report the client";
  }

  [[nodiscard]] WebServer& web() { return web_; }
  [[nodiscard]] ClientId id() const { return id_; }
  /// Whether a frame has arrived. Answers pings meanwhile.
  [[nodiscard]] bool has_frame() {
    begin_read();
    io_.restart();
    io_.poll();
    return arrived_;
  }
  /// The next frame, binary or text. Waits for it, so the relay must have sent it before.
  [[nodiscard]] std::string read() {
    begin_read();
    for (io_.restart(); !arrived_;) io_.run_one();
    reading_ = false;
    std::string frame = boost::beast::buffers_to_string(frame_.data());
    frame_.clear();
    return frame;
  }
  [[nodiscard]] foxglove::json read_json() { return foxglove::json::parse(read()); }

 private:
  WebServer web_{{.port = 0}, foxglove::kSubprotocols, {}, [](const std::string&) {}};
  void begin_read() {
    if (std::exchange(reading_, true)) return;
    arrived_ = false;
    stream_.async_read(frame_, [this](const boost::system::error_code& error, std::size_t) {
      if (error) throw std::runtime_error("the server closed the connection: " + error.message());
      arrived_ = true;
    });
  }

  boost::asio::io_context io_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> stream_{io_};
  boost::beast::flat_buffer frame_;
  bool reading_ = false, arrived_ = false;
  ClientId id_ = 0;
};

}  // namespace tandem::test
