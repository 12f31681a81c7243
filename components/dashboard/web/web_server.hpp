// SPDX-License-Identifier: Apache-2.0
// The web server: serves the page over HTTP and turns WebSocket messages into a sequence of events.
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
    field("address", address,
          "address to listen on; clients need a token unless it is a loopback address");
    field("port", port, Range{0, 65500},
          "TCP port, or the first free one of the ten from it on; 0: any; the log names the port "
          "in use");
    field("token_file", token_file,
          "file whose first line is the token that clients send as ?token=… ; empty: no token on "
          "loopback, elsewhere a new one at each start, printed in the terminal");
    field("allowed_origins", allowed_origins,
          "other sites whose pages may connect, \"https://a.b https://c.d\"; native programs "
          "always may");
    field("trusted_proxies", trusted_proxies,
          "addresses of reverse proxies whose X-Forwarded-For is trusted, \"127.0.0.1 ::1\"; if "
          "any is given, clients need a token on loopback too");
    field("max_clients", max_clients, Range{1, 1000}, "maximum number of connections at a time");
    field("max_message", max_message, Range{1024, 16777216},
          "[B] maximum size of a client's frame");
    field("max_rate", max_rate, Range{1.0, 1e5},
          "[Hz] maximum frame rate of a client; above it the client is disconnected");
    field("max_byte_rate", max_byte_rate, Range{0.01, 1000.0},
          "[MB/s] maximum rate at which a client's data is read; more waits in its socket");
    field("max_backlog", max_backlog, Range{1.0, 1000.0},
          "[MB] maximum backlog of a client; above it the client is disconnected");
  }
};

inline constexpr double kReaderCost = 0.002;   // [s] cost of a new reader in all processes
inline constexpr double kCallCost = 0.005;     // [s] cost of a service call in other nodes
inline constexpr double kCostPerByte = 20e-9;  // [s] cost per byte of an answer

/// A file of the page, embedded in the library.
struct WebFile {
  std::string_view content_type, bytes;
};

/// A frame to a client: its own header and a body that may be shared.
struct WebFrame {
  bool text = false;
  std::string head;
  std::shared_ptr<const std::vector<std::uint8_t>> body{};
  bool shared = false;  ///< other clients receive the same body
};

[[nodiscard]] inline std::shared_ptr<const std::vector<std::uint8_t>> body_of(
    std::string_view text) {
  return std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end());
}

/// Serves files over HTTP and WebSocket clients on its own thread. Calls never wait for the
/// network. A client that misbehaves (too much, too fast, too slow, wrong origin, no token) is
/// disconnected.
class WebServer {
 public:
  using Log = std::function<void(const std::string&)>;  ///< called on the server's thread

  /// Starts listening. Throws std::invalid_argument with one line if it cannot.
  /// `subprotocols`: preferred first.
  WebServer(const WebServerParams& params, std::vector<std::string> subprotocols,
            std::map<std::string, WebFile> files, Log log);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// The next event of a lane; nullopt if there is none.
  [[nodiscard]] std::optional<WebEvent> next(Lane lane);
  /// Charges the client for the work [s] that an event has caused, here or in other nodes.
  void charge(ClientId client, double work);
  /// Marks binary frames of the client with one of these prefixes as urgent.
  void set_urgent(ClientId client, std::vector<std::string> prefixes);
  /// Does not block; frames to a disconnected client are dropped.
  void send(ClientId client, WebFrame frame);
  /// Sends the same text to many clients.
  template <class ClientIds>
  void send_text(const ClientIds& clients, std::string_view text) {
    const auto body = body_of(text);
    for (const ClientId client : clients) send(client, {true, {}, body, true});
  }
  /// Sends an answer to a client's request: like send, but the client is charged for the bytes.
  void answer(ClientId client, WebFrame frame);

  [[nodiscard]] int port() const;
  /// URL of the page, without the token.
  [[nodiscard]] std::string url() const;
  /// Token that clients must present; empty: none.
  [[nodiscard]] const std::string& token() const;

 private:
  friend class WebConnection;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
