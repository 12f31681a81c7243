// SPDX-License-Identifier: Apache-2.0
// In: TCP connections. Out: what web clients say, one event after another; files for browsers.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/dashboard/driver_lock.hpp"
#include "tandem/dashboard/web/client_queues.hpp"

namespace tandem {

struct WebServerParams {
  std::string address = "127.0.0.1";
  int port = 8765;
  std::string token_file{};
  std::string allowed_origins{};
  std::string trusted_proxies{};
  int max_clients = 16;
  int max_message = 65536;
  double max_rate = 300.0;
  double max_byte_rate = 0.5;
  double max_backlog = 16.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("address", address, "where to listen; on one that is not loopback clients need a token");
    field("port", port, Range{0, 65500},
          "TCP port, or the next free one of ten; 0: any; the log names it");
    field(
        "token_file", token_file,
        "its first line is what clients say as ?token=… ; empty: none on loopback, elsewhere a new "
        "one at each start, told in the terminal");
    field("allowed_origins", allowed_origins,
          "other sites whose pages may connect, \"https://a.b https://c.d\"; native programs "
          "always may");
    field("trusted_proxies", trusted_proxies,
          "addresses of reverse proxies whose X-Forwarded-For is believed, \"127.0.0.1 ::1\"; with "
          "any, clients need a token on loopback too");
    field("max_clients", max_clients, Range{1, 1000}, "connections at a time");
    field("max_message", max_message, Range{1024, 16777216}, "[B] of one frame of a client");
    field("max_rate", max_rate, Range{1.0, 1e5}, "[Hz] frames of one client; more: it is dropped");
    field("max_byte_rate", max_byte_rate, Range{0.01, 1000.0},
          "[MB/s] that are read of one client; more waits in its socket");
    field("max_backlog", max_backlog, Range{1.0, 1000.0},
          "[MB] that a client may lag behind; more: it is dropped");
  }
};

inline constexpr double kReaderCost = 0.002;   // [s] that a new reader costs here and there
inline constexpr double kCallCost = 0.005;     // [s] that a service call costs other nodes
inline constexpr double kCostPerByte = 20e-9;  // [s] of an answer

/// A file of the page, and where it lies in memory.
struct WebFile {
  std::string_view content_type, bytes;
};

/// A frame to a client: a head of its own and a body.
struct WebFrame {
  bool text = false;
  std::string head;
  std::shared_ptr<const std::vector<std::uint8_t>> body{};
  bool shared = false;  ///< other clients get the same body
};

[[nodiscard]] inline std::shared_ptr<const std::vector<std::uint8_t>> body_of(
    std::string_view text) {
  return std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end());
}

/// Serves files over HTTP and speaks WebSocket, on a thread of its own: nothing here ever waits
/// for the network, and a client that misbehaves (too much, too fast, too slow, from a strange
/// site, without the token) loses its connection.
class WebServer {
 public:
  using Log = std::function<void(const std::string&)>;  ///< called on the server's thread

  /// Listens at once. Throws std::invalid_argument in one line if it cannot.
  WebServer(const WebServerParams& params, std::string subprotocol,
            std::map<std::string, WebFile> files, Log log);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// The next event of a lane, if there is one.
  [[nodiscard]] std::optional<WebEvent> next(Lane lane);
  /// Work [s] that an event of the client has cost, here or in other nodes.
  void charge(ClientId client, double work);
  /// Binary frames of the client that begin with one of these bytes are urgent.
  void set_urgent(ClientId client, std::vector<std::string> prefixes);
  /// Does not wait; a client that is gone gets nothing.
  void send(ClientId client, WebFrame frame);
  /// The same text to many.
  template <class ClientIds>
  void send_text(const ClientIds& clients, std::string_view text) {
    const auto body = body_of(text);
    for (const ClientId client : clients) send(client, {true, {}, body, true});
  }
  /// The same for what the client has asked for: it is charged for the bytes.
  void answer(ClientId client, WebFrame frame);

  [[nodiscard]] int port() const;
  /// Where a browser finds the page; the token is not told.
  [[nodiscard]] std::string url() const;
  /// What clients have to say; empty: nothing.
  [[nodiscard]] const std::string& token() const;

 private:
  friend class WebConnection;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
