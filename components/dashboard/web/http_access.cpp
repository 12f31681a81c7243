// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/http_access.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <stdexcept>

#include <boost/asio/ip/address.hpp>

namespace tandem::http_access {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;

constexpr int kPorts = 10;  // ports tried

std::string text_of(beast::string_view view) { return {view.data(), view.size()}; }

// "a.b:80" → "a.b", "[::1]:80" → "::1"
std::string host_name(const std::string& host) {
  if (host.starts_with("[")) return host.substr(1, host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

bool is_loopback_name(const std::string& name) {
  if (name == "localhost") return true;
  boost::system::error_code error;
  const auto address = asio::ip::make_address(name, error);
  return !error && address.is_loopback();
}

// Constant time, so that the duration does not reveal where the strings differ.
bool same_secret(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

// The value of a key of "path?key=value&…".
std::string query_value(const std::string& target, const std::string& key) {
  const auto question = target.find('?');
  if (question == std::string::npos) return {};
  std::string query = "&" + target.substr(question + 1);
  const auto at = query.find("&" + key + "=");
  if (at == std::string::npos) return {};
  const auto start = at + key.size() + 2;
  return query.substr(start, query.find('&', start) - start);
}

bool has_word(const std::string& list, const std::string& word, char separator) {
  std::string padded;
  for (const char c : list) padded.push_back(c == ' ' ? separator : c);
  padded = separator + padded + separator;
  return padded.find(separator + word + separator) != std::string::npos;
}

// Hosts that the page may connect to; in older browsers 'self' alone excludes WebSockets. A host
// with invalid characters is left out, because it could inject words into the policy.
std::string own_hosts(const Request& request) {
  const std::string host = text_of(request[http::field::host]);
  const bool is_host = !host.empty() && std::all_of(host.begin(), host.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':' || c == '[' || c == ']';
  });
  return is_host ? "'self' ws://" + host + " wss://" + host : "'self'";
}

// Throws std::invalid_argument if the address is not an IP address.
asio::ip::address address_of(const WebServerParams& params) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(params.address, error);
  if (error)
    throw std::invalid_argument("address = \"" + params.address +
                                "\" is not an IP address (127.0.0.1, 0.0.0.0, ::1, …)");
  return address;
}

boost::system::error_code listen_on(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
  boost::system::error_code error;
  acceptor = tcp::acceptor{acceptor.get_executor()};
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error;
}

}  // namespace

tcp::acceptor listen(asio::io_context& io, const WebServerParams& params) {
  const auto address = address_of(params);
  tcp::acceptor acceptor{io};
  boost::system::error_code error;
  for (int i = 0; i < (params.port == 0 ? 1 : kPorts); ++i) {
    error = listen_on(acceptor, {address, static_cast<unsigned short>(params.port + i)});
    if (!error) return acceptor;
  }
  throw std::invalid_argument(params.address + ":" + std::to_string(params.port) +
                              " is not available, nor are the ports after it (" + error.message() +
                              "): choose another `port`");
}

std::string chosen_subprotocol(const Request& request,
                               const std::vector<std::string>& subprotocols) {
  const std::string offered = text_of(request[http::field::sec_websocket_protocol]);
  const auto found =
      std::find_if(subprotocols.begin(), subprotocols.end(),
                   [&](const std::string& name) { return has_word(offered, name, ','); });
  return found == subprotocols.end() ? "" : *found;
}

std::optional<Refusal> refuse(const Request& request, const Rules& rules) {
  const auto& params = rules.params;
  const auto field = [&](http::field name) { return text_of(request[name]); };
  const std::string host = field(http::field::host), origin = field(http::field::origin);
  // Against DNS rebinding: a page of another site can reach loopback under that site's name.
  if (rules.loopback && !is_loopback_name(host_name(host)))
    return Refusal{"the host \"" + host + "\" is not this machine"};
  if (!origin.empty() && origin != "http://" + host && origin != "https://" + host &&
      !has_word(params.allowed_origins, origin, ' '))
    return Refusal{"pages from " + origin + " may not connect (allowed_origins)"};
  if (!rules.token.empty()) {
    const std::string given = query_value(text_of(request.target()), "token");
    if (!same_secret(given, rules.token))
      return Refusal{"the token is missing or wrong (?token=...)", !given.empty()};
  }
  if (chosen_subprotocol(request, rules.subprotocols).empty())
    return Refusal{"the subprotocol " + rules.subprotocols.front() + " is not offered"};
  if (rules.clients >= params.max_clients)
    return Refusal{"already " + std::to_string(params.max_clients) +
                   " clients connected (max_clients)"};
  return std::nullopt;
}

Response answer(const Request& request, const std::map<std::string, WebFile>& files) {
  const std::string target = text_of(request.target());
  const auto file = files.find(target.substr(0, target.find('?')));
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Response{http::status::method_not_allowed, 11};
  }
  if (file == files.end()) {
    Response response{http::status::not_found, 11};
    response.body() = "not found\n";
    return response;
  }
  Response response{http::status::ok, 11};
  const auto& [type, bytes] = file->second;
  response.set(http::field::content_type, beast::string_view{type.data(), type.size()});
  response.set(http::field::cache_control, "no-cache");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Content-Security-Policy",
               "default-src 'self'; connect-src " + own_hosts(request) +
                   "; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; "
                   "form-action 'none'");
  if (request.method() == http::verb::get) response.body() = std::string{bytes};
  return response;
}

}  // namespace tandem::http_access
