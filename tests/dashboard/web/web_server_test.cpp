// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/web_server.hpp"

#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tandem/dashboard/web/page_files.hpp"
#include "tandem/dashboard/web/token_delay.hpp"

namespace tandem {
namespace {

namespace asio = boost::asio;

std::unique_ptr<WebServer> serve(const WebServerParams& params) {
  return std::make_unique<WebServer>(params, std::vector<std::string>{"test"}, page_files(),
                                     [](const std::string&) {});
}

std::string why_not(const WebServerParams& params) {
  try {
    serve(params);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

// The complete response to a request.
std::string ask(const WebServer& server, const std::string& request) {
  asio::io_context io;
  asio::ip::tcp::socket socket{io};
  socket.connect({asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server.port())});
  asio::write(socket, asio::buffer(request));
  std::string answer;
  boost::system::error_code end;
  asio::read(socket, asio::dynamic_buffer(answer), end);
  return answer;
}

TEST(WebServer, ServesThePageAndNothingElse) {
  const auto server = serve({.port = 0});
  const std::string page = ask(*server, "GET /?token=x HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_TRUE(page.starts_with("HTTP/1.1 200")) << page;
  EXPECT_NE(page.find("<title>Tandem</title>"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'self'"), std::string::npos);
  for (const char* part : {"connect-src 'self' ws://a wss://a;", "base-uri 'none'",
                           "form-action 'none'", "frame-ancestors 'none'"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_NE(
      ask(*server, "GET / HTTP/1.1\r\nHost: a; img-src *\r\n\r\n").find("connect-src 'self';"),
      std::string::npos)
      << "a host that would add to the policy";
  for (const char* path : {"/../../etc/passwd", "/app.js/", "/x"})
    EXPECT_TRUE(ask(*server, std::string{"GET "} + path + " HTTP/1.1\r\nHost: a\r\n\r\n")
                    .starts_with("HTTP/1.1 404"));
  EXPECT_TRUE(ask(*server, "PUT / HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\n\r\n")
                  .starts_with("HTTP/1.1 405"));
}

TEST(WebServer, RequiresATokenIfOthersCanReachIt) {
  EXPECT_EQ(serve({.port = 0})->token(), "");
  const auto token = serve({.address = "0.0.0.0", .port = 0})->token();
  EXPECT_EQ(token.size(), 32U);
  EXPECT_NE(serve({.address = "0.0.0.0", .port = 0})->token(), token) << "a new one at each start";
}

TEST(WebServer, RequiresATokenOnLoopbackTooBehindAProxy) {
  EXPECT_NE(serve({.port = 0, .trusted_proxies = "127.0.0.1"})->token(), "");
  EXPECT_NE(why_not({.port = 0, .trusted_proxies = "proxy"}).find("trusted_proxies"),
            std::string::npos);
}

constexpr const char* kToken = "a-token_of_25_characters_";

std::unique_ptr<WebServer> serve_with_token(const std::string& proxies = {}) {
  const auto path = std::filesystem::path{testing::TempDir()} / "token_of_the_door";
  std::ofstream{path} << kToken << "\n";
  return serve({.port = 0, .token_file = path, .trusted_proxies = proxies});
}

// The response header for a client with that token, optionally behind a proxy.
std::string come_in(const WebServer& server, const std::string& token,
                    const std::string& forwarded = {}) {
  asio::io_context io;
  asio::ip::tcp::socket socket{io};
  socket.connect({asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server.port())});
  asio::write(
      socket,
      asio::buffer("GET /?token=" + token +
                   " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                   "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                   "Sec-WebSocket-Protocol: test\r\n" +
                   (forwarded.empty() ? "" : "X-Forwarded-For: " + forwarded + "\r\n") + "\r\n"));
  std::string answer;
  boost::system::error_code end;
  asio::read_until(socket, asio::dynamic_buffer(answer), "\r\n\r\n", end);
  return answer;
}

int status(const std::string& answer) { return std::stoi(answer.substr(9)); }

TEST(WebServer, DelaysWrongTokensAndNeverAValidOne) {
  const auto server = serve_with_token();
  std::string last;
  for (int i = 0; i < 20; ++i) {
    last = come_in(*server, "wrong" + std::to_string(i));
    if (i > TokenDelay::kFree) {
      EXPECT_EQ(status(last), 429) << i;
    } else if (i < TokenDelay::kFree) {
      EXPECT_EQ(status(last), 403) << i;
    }
    EXPECT_EQ(status(come_in(*server, kToken)), 101) << "while the delay runs, too";
  }
  EXPECT_EQ(status(come_in(*server, "wrong")), 429);
  const auto retry = last.find("Retry-After: ");
  ASSERT_NE(retry, std::string::npos) << last;
  EXPECT_GT(std::stoi(last.substr(retry + 13)), 1);
  EXPECT_LE(std::stoi(last.substr(retry + 13)), 60);
}

TEST(WebServer, DistinguishesClientsBehindATrustedProxy) {
  const auto server = serve_with_token("127.0.0.1");
  for (int i = 0; i < 20; ++i) (void)come_in(*server, "wrong", "10.0.0.1");
  EXPECT_EQ(status(come_in(*server, "wrong", "10.0.0.1")), 429);
  EXPECT_EQ(status(come_in(*server, "wrong", "10.0.0.2")), 403);
  EXPECT_EQ(status(come_in(*server, "wrong", "10.0.0.2, 10.0.0.1")), 429);
  EXPECT_EQ(status(come_in(*server, kToken, "10.0.0.1")), 101);
}

TEST(WebServer, IgnoresHeadersOfUntrustedPeers) {
  const auto server = serve_with_token();
  for (int i = 0; i < 20; ++i) (void)come_in(*server, "wrong", "10.0.0." + std::to_string(i));
  EXPECT_EQ(status(come_in(*server, "wrong", "10.0.0.99")), 429);
}

// Each client sends half a request and never finishes it.
TEST(WebServer, AdmitsATokenHolderPastSilentConnections) {
  for (const char* proxies : {"", "127.0.0.1"}) {
    const auto server = serve_with_token(proxies);
    asio::io_context io;
    std::vector<asio::ip::tcp::socket> silent;
    for (int i = 0; i < 200; ++i) {
      silent.emplace_back(io).connect(
          {asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server->port())});
      boost::system::error_code closed;
      asio::write(silent.back(), asio::buffer(std::string{"GET / HT"}), closed);
    }
    for (int i = 0; i < 5; ++i) EXPECT_EQ(status(come_in(*server, kToken)), 101) << proxies;
  }
}

TEST(WebServer, LimitsAnswersToAStranger) {
  const auto server = serve({.port = 0});
  const std::string request = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
  int answered = 0;
  std::string last;
  while (answered < 5000 && (last = ask(*server, request)).starts_with("HTTP/1.1 200")) ++answered;
  EXPECT_GE(answered, 200);
  EXPECT_TRUE(last.starts_with("HTTP/1.1 429")) << last.substr(0, 60);
}

TEST(WebServer, TakesItsTokenFromAFile) {
  const auto path = std::filesystem::path{testing::TempDir()} / "token";
  const auto says = [&](const std::string& line) {
    std::ofstream{path} << line;
    return why_not({.port = 0, .token_file = path});
  };
  EXPECT_EQ(says("se-cret_1-of-12\nand more\n"), "");
  EXPECT_EQ(serve({.port = 0, .token_file = path})->token(), "se-cret_1-of-12");
  for (const char* line :
       {"\n", "short", "eleven_long", "a&b=c d and more", "\xff\xfe\xfd\xfc\xfb\xfa"})
    EXPECT_NE(says(line).find("letters"), std::string::npos) << line;
  EXPECT_NE(says(std::string(200, 'a')).find("128"), std::string::npos);
  EXPECT_NE(says("").find("is empty"), std::string::npos);
  std::filesystem::remove(path);
  EXPECT_NE(why_not({.port = 0, .token_file = path}).find("is not readable"), std::string::npos);
}

TEST(WebServer, ListensOnAddressesOnly) {
  EXPECT_NE(why_not({.address = "localhost", .port = 0}).find("not an IP address"),
            std::string::npos);
}

TEST(WebServer, TakesTheNextPortIfItsOwnIsTaken) {
  const auto first = serve({.port = 0});
  const auto second = serve({.port = first->port()});
  EXPECT_GT(second->port(), first->port());
  EXPECT_LT(second->port(), first->port() + 10);
}

TEST(WebServer, EndsWhileClientsAreConnected) {
  asio::io_context io;
  asio::ip::tcp::socket socket{io};
  {
    const auto server = serve({.port = 0});
    socket.connect(
        {asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server->port())});
    asio::write(socket, asio::buffer(std::string{"GET / HT"}));
  }
  char rest = 0;
  boost::system::error_code end;
  asio::read(socket, asio::buffer(&rest, 1), end);
  EXPECT_TRUE(end);
}

}  // namespace
}  // namespace tandem
