// SPDX-License-Identifier: Apache-2.0
// Access control of the web server: where it listens, which requests may open a WebSocket, and the
// answers to HTTP requests.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http.hpp>

#include "tandem/dashboard/web/web_server.hpp"

namespace tandem::http_access {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// Listens at the address of the parameters. Throws std::invalid_argument with one line if it
/// cannot.
[[nodiscard]] boost::asio::ip::tcp::acceptor listen(boost::asio::io_context& io,
                                                    const WebServerParams& params);

struct Rules {
  const WebServerParams& params;
  const std::vector<std::string>& subprotocols;  ///< those that the server speaks
  const std::string& token;                      ///< empty: no token is needed
  bool loopback = true;                          ///< only this machine can connect
  int clients = 0;                               ///< connected clients
};

/// Why a request was refused, in one sentence for the client.
struct Refusal {
  std::string reason;
  bool wrong_token = false;  ///< a token was given, but the wrong one
};

/// Why the request may not become a WebSocket: its host or origin, the token, the subprotocol, too
/// many clients; nullopt if it may.
[[nodiscard]] std::optional<Refusal> refuse(const Request& request, const Rules& rules);

/// The first subprotocol of the server that the client offers; empty if there is none.
[[nodiscard]] std::string chosen_subprotocol(const Request& request,
                                             const std::vector<std::string>& subprotocols);

/// The requested file, or an error response.
[[nodiscard]] Response answer(const Request& request, const std::map<std::string, WebFile>& files);

}  // namespace tandem::http_access
