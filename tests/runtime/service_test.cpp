// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "runtime/node.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using std_srvs::srv::SetBool;
using test::spin_until;

constexpr double kTimeout = 10.0;  // [s]
constexpr rt::ServiceName<SetBool> kSwitch{"switch"};

SetBool::Request request(bool data) {
  SetBool::Request result;
  result.data(data);
  return result;
}

void answer(const SetBool::Request& asked, SetBool::Response& response) {
  response.success(asked.data());
  response.message(asked.data() ? "on" : "off");
}

TEST(Service, AnswersEachCallWithItsOwnAnswer) {
  rt::Node server{"server"}, asker{"asker"};
  const auto service = server.create_service(kSwitch, answer);
  const auto client = asker.create_client(kSwitch);
  std::string answers;
  for (const bool data : {true, false, true})
    client.call(request(data), [&](const auto& r) { answers += r.message() + " "; });
  ASSERT_TRUE(spin_until([&] { return answers.size() >= 10; }, kTimeout, server, asker));
  EXPECT_EQ(answers, "on off on ");
  EXPECT_TRUE(client.ready());
}

TEST(Service, KeepsTwoClientsApart) {
  rt::Node server{"server"}, first{"first"}, second{"second"};
  const auto service = server.create_service(kSwitch, answer);
  const auto client_1 = first.create_client(kSwitch);
  const auto client_2 = second.create_client(kSwitch);
  int right = 0, wrong = 0;
  for (int i = 0; i < 20; ++i) {
    client_1.call(request(true), [&](const auto& r) { ++(r.success() ? right : wrong); });
    client_2.call(request(false), [&](const auto& r) { ++(r.success() ? wrong : right); });
  }
  ASSERT_TRUE(spin_until([&] { return right + wrong == 40; }, kTimeout, server, first, second));
  EXPECT_EQ(wrong, 0);
}

TEST(Client, CallWithoutAServerTimesOutOnce) {
  rt::Node asker{"lonely"};
  const auto client = asker.create_client(kSwitch);
  int answers = 0, timeouts = 0;
  client.call(
      request(true), [&](const auto&) { ++answers; }, 0.05, [&] { ++timeouts; });
  EXPECT_FALSE(client.ready());
  ASSERT_TRUE(spin_until([&] { return timeouts == 1; }, kTimeout, asker));
  asker.spin_some(0.05);
  EXPECT_EQ(timeouts, 1);
  EXPECT_EQ(answers, 0);
}

TEST(Client, CallToASilentServerTimesOut) {
  rt::Node silent{"silent"}, asker{"asker"};
  const auto service = silent.create_service(kSwitch, answer);
  const auto client = asker.create_client(kSwitch);
  int timeouts = 0;
  ASSERT_TRUE(spin_until([&] { return client.ready(); }, kTimeout, asker));
  client.call(
      request(true), [](const auto&) {}, 0.05, [&] { ++timeouts; });
  EXPECT_TRUE(spin_until([&] { return timeouts == 1; }, kTimeout, asker));
}

TEST(Client, MayBeClosedByItsOwnAnswer) {
  rt::Node server{"server"}, asker{"asker"};
  auto service = server.create_service(kSwitch, answer);
  auto client = asker.create_client(kSwitch);
  bool answered = false;
  client.call(request(true), [&](const auto&) {
    client = {};
    answered = true;
  });
  EXPECT_TRUE(spin_until([&] { return answered; }, kTimeout, server, asker));
}

}  // namespace
}  // namespace tandem
