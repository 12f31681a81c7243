// SPDX-License-Identifier: Apache-2.0
// Where the server listens, who may come in, and what a browser gets that asks for a file.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http.hpp>

#include "tandem/dashboard/web/web_server.hpp"

namespace tandem::web_door {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// Listens where the parameters say. Throws std::invalid_argument in one line if it cannot.
[[nodiscard]] boost::asio::ip::tcp::acceptor listen(boost::asio::io_context& io,
                                                    const WebServerParams& params);

struct Rules {
  const WebServerParams& params;
  const std::string& subprotocol;
  const std::string& token;  ///< empty: none is needed
  bool loopback = true;      ///< only this machine can reach the door
  int clients = 0;           ///< that are inside
};

/// One sentence for the client.
struct Refusal {
  std::string reason;
  bool wrong_token = false;  ///< one was said
};

/// Why the request may not become a WebSocket: the host or the site it comes from, the token, the
/// subprotocol, too many inside; nothing: it may.
[[nodiscard]] std::optional<Refusal> refuse(const Request& request, const Rules& rules);

/// The file that it asks for, or what is wrong with asking.
[[nodiscard]] Response answer(const Request& request, const std::map<std::string, WebFile>& files);

}  // namespace tandem::web_door
