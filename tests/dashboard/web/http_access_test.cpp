// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/http_access.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "dashboard/damaged.hpp"

namespace tandem::http_access {
namespace {

namespace http = boost::beast::http;

constexpr const char* kProtocol = "foxglove.websocket.v1";
const std::vector<std::string> kProtocols{kProtocol, "foxglove.sdk.v1"};

struct Visit {
  std::string target = "/", host = "127.0.0.1:8765", origin{}, protocol = kProtocol;
};

Request request(const Visit& visit) {
  Request request{http::verb::get, visit.target, 11};
  request.set(http::field::host, visit.host);
  if (!visit.origin.empty()) request.set(http::field::origin, visit.origin);
  request.set(http::field::sec_websocket_protocol, visit.protocol);
  return request;
}

bool comes_in(const Visit& visit, const WebServerParams& params = {}, int clients = 0) {
  return !refuse(request(visit), {params, kProtocols, "", true, clients});
}

TEST(HttpAccess, AdmitsProgramsAndItsOwnPage) {
  EXPECT_TRUE(comes_in({}));
  EXPECT_TRUE(comes_in({.origin = "http://127.0.0.1:8765"}));
  EXPECT_TRUE(comes_in({.host = "localhost:1", .origin = "http://localhost:1"}));
  EXPECT_TRUE(comes_in({.host = "[::1]:8765", .protocol = "other, foxglove.websocket.v1"}));
}

TEST(HttpAccess, ChoosesAProtocolThatTheClientOffers) {
  const auto chosen = [](const std::string& offered) {
    return chosen_subprotocol(request({.protocol = offered}), kProtocols);
  };
  EXPECT_EQ(chosen("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(chosen("foxglove.sdk.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(chosen("foxglove.sdk.v1, foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(chosen("foxglove.sdk.v2"), "");
  EXPECT_FALSE(comes_in({.protocol = "foxglove.sdk.v2"}));
}

TEST(HttpAccess, RefusesPagesOfOtherSites) {
  EXPECT_FALSE(comes_in({.origin = "http://127.0.0.1:8766"}));
  EXPECT_FALSE(comes_in({.origin = "null"}));
  EXPECT_FALSE(comes_in({.host = "evil.example", .origin = "http://evil.example"}));
  EXPECT_FALSE(comes_in({.host = "127.0.0.1.evil.example"}));
  EXPECT_FALSE(comes_in({.host = "[::1"}, {}, 16));
  const WebServerParams allowing{.allowed_origins = "https://a.b https://c.d"};
  EXPECT_TRUE(comes_in({.origin = "https://c.d"}, allowing));
  EXPECT_FALSE(comes_in({.origin = "https://c"}, allowing));
}

TEST(HttpAccess, RequiresTheExactToken) {
  const WebServerParams params{.address = "0.0.0.0"};
  const auto says = [&](const std::string& target) {
    return !refuse(request({.target = target, .host = "robot"}),
                   {params, kProtocols, "secret", false, 0});
  };
  EXPECT_TRUE(says("/?token=secret"));
  EXPECT_TRUE(says("/?a=b&token=secret&c=d"));
  for (const char* target : {"/", "/?token=", "/?token=secre", "/?token=secrets", "/?xtoken=secret",
                             "/?token", "/token=secret", "/?token=guess&token=secret"})
    EXPECT_FALSE(says(target)) << target;
}

TEST(HttpAccess, RefusesOtherProtocolsAndClientsBeyondTheLimit) {
  EXPECT_FALSE(comes_in({.protocol = ""}));
  EXPECT_FALSE(comes_in({.protocol = "foxglove.websocket.v10"}));
  EXPECT_TRUE(comes_in({}, {.max_clients = 2}, 1));
  EXPECT_FALSE(comes_in({}, {.max_clients = 2}, 2));
}

// A damaged token is never accepted, and nothing is thrown.
TEST(HttpAccess, TakesAnyRequest) {
  const WebServerParams params{.address = "0.0.0.0"};
  const std::vector<std::string> targets{"/?token=wrong", "/?token", "/?a=b&token=other&c", "?&=?&",
                                         "/app.js"};
  const std::vector<std::string> hosts{"127.0.0.1:8765", "[::1]:8765", "localhost", "robot.local"};
  const std::map<std::string, WebFile> files{{"/app.js", {"text/javascript", "x"}}};
  std::mt19937 random{7};
  for (int i = 0; i < 100'000; ++i) {
    const Visit visit{.target = test::damaged(targets, random),
                      .host = test::damaged(hosts, random),
                      .origin = test::damaged(hosts, random)};
    const Request asked = request(visit);
    EXPECT_TRUE(refuse(asked, {params, kProtocols, "secret", false, 0})) << visit.target;
    const auto status = answer(asked, files).result();
    EXPECT_EQ(status == http::status::ok,
              visit.target.substr(0, visit.target.find('?')) == "/app.js");
  }
}

}  // namespace
}  // namespace tandem::http_access
