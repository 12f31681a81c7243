// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using std_srvs::srv::SetBool;
using test::spin_until;

using test::kTimeout;
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

// A client as of ros2-client in Rust: its request does not tell which reader the answer is for, and
// that reader is discovered after one of another client in the same participant.
class ClientThatNamesNoReader : public testing::Test {
 protected:
  rt::Endpoint request_{rt::dds_request_name("/switch"),
                        rt::Codec{rt::type_ref<SetBool::Request>()}.dds_name(), rt::kDefault};
  rt::Endpoint reply_{rt::dds_reply_name("/switch"),
                      rt::Codec{rt::type_ref<SetBool::Response>()}.dds_name(), rt::kDefault};
  std::shared_ptr<rt::Participant> participant_ = rt::Participant::shared();

  std::unique_ptr<rt::Reader> count_into(int& count) {
    const auto deliver = [&count](const auto&, const auto&) { return ++count > 0; };
    return std::make_unique<rt::Reader>(*participant_, reply_, deliver, rt::Reader::Refused{});
  }
};

TEST_F(ClientThatNamesNoReader, IsAnsweredWhereAnotherClientWasBefore) {
  rt::Node server{"server"};
  const auto service = server.create_service(kSwitch, answer);
  int by_first = 0, by_second = 0;
  const auto first = count_into(by_first);
  rt::Writer writer{*participant_, request_};
  ASSERT_TRUE(
      spin_until([&] { return writer.matched() == 1 && first->matched() == 1; }, kTimeout, server));
  rt::Bytes bytes;
  const auto asked = request(true);
  ASSERT_TRUE(rt::Codec{rt::type_ref<SetBool::Request>()}.encode(&asked, bytes));
  ASSERT_TRUE(writer.write(bytes));
  ASSERT_TRUE(spin_until([&] { return first->drain() > 0; }, kTimeout, server));
  const auto second = count_into(by_second);
  EXPECT_TRUE(spin_until([&] { return second->drain() > 0; }, kTimeout, server));
}

}  // namespace
}  // namespace tandem
