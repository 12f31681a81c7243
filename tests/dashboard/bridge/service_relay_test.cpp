// SPDX-License-Identifier: Apache-2.0
// Tests how web clients call services of the domain.
#include "tandem/dashboard/bridge/service_relay.hpp"

#include <gtest/gtest.h>

#include <string>

#include "dashboard/bridge/page_client.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using foxglove::json;
using std_srvs::srv::SetBool;
using std_srvs::srv::Trigger;

constexpr const char* kOwnService = "/dashboard/take_over";

class ServiceRelayOverDds : public testing::Test {
 protected:
  template <class Done>
  bool spin_until(Done done, double timeout = test::kTimeout) {
    return test::spin_until(done, timeout, dashboard_, target_);
  }
  // The id under which the service is offered.
  std::uint32_t id_of(const std::string& name) {
    EXPECT_TRUE(spin_until([&] {
      relay_.look({page_.id()});
      if (!ids_.contains(name) && page_.has_frame()) note(page_.read_json());
      return ids_.contains(name);
    })) << name;
    return ids_[name];
  }
  void note(const json& frame) {
    if (frame.at("op") != "advertiseServices") return;
    for (const auto& service : frame.at("services")) ids_[service.at("name")] = service.at("id");
  }
  void call(std::uint32_t service, const foxglove::Bytes& payload, std::uint32_t number = 7,
            const std::string& encoding = "cdr") {
    relay_.call(page_.id(), {service, number, encoding, payload});
  }
  std::string answer(double timeout = test::kTimeout) {
    EXPECT_TRUE(spin_until([&] { return page_.has_frame(); }, timeout));
    return page_.read();
  }
  std::string failure() { return json::parse(answer()).at("message"); }
  // Of a binary answer to call 7 of the service.
  static std::string payload_of(const std::string& frame, std::uint32_t service) {
    const std::string head = foxglove::response_head({service, 7, "cdr", {}});
    EXPECT_EQ(frame.substr(0, head.size()), head);
    return frame.substr(head.size());
  }
  template <class Message>
  static std::string encoded(const Message& message) {
    const auto bytes = rt::encode(message);
    return {bytes.begin(), bytes.end()};
  }

  rt::Node dashboard_{"dashboard"};
  rt::Node target_{rt::NodeOptions{.name = "target", .ns = "/a"}};
  bool light_ = false;
  std::optional<rt::Service> set_light_ = target_.create_service(
      rt::ServiceName<SetBool>{"~/set_light"}, [this](const auto& request, auto& response) {
        light_ = request.data();
        response.success(true);
        response.message("done");
      });
  std::map<std::string, std::uint32_t> ids_;
  ClientId taken_by_ = 0;
  test::PageClient page_;
  ServiceRelay relay_{dashboard_, page_.web(), kOwnService, [this](ClientId client) {
                        taken_by_ = client;
                        Trigger::Response response;
                        response.success(true);
                        return response;
                      }};
};

TEST_F(ServiceRelayOverDds, CallsAServiceAndReturnsItsResponse) {
  const std::uint32_t id = id_of("/a/target/set_light");
  EXPECT_EQ(relay_.name(id), "/a/target/set_light");
  SetBool::Request request;
  request.data(true);
  call(id, rt::encode(request));
  SetBool::Response response;
  response.success(true);
  response.message("done");
  EXPECT_EQ(payload_of(answer(), id), encoded(response));
  EXPECT_TRUE(light_);
}

TEST_F(ServiceRelayOverDds, AnswersItsOwnServiceItself) {
  relay_.announce_all(page_.id());
  const json services = page_.read_json().at("services");
  ASSERT_EQ(services.at(0).at("name"), kOwnService);
  const std::uint32_t id = services.at(0).at("id");
  call(id, rt::encode(Trigger::Request{}));
  Trigger::Response response;
  response.success(true);
  EXPECT_EQ(payload_of(answer(), id), encoded(response));
  EXPECT_EQ(taken_by_, page_.id());
}

TEST_F(ServiceRelayOverDds, OpensOnlyWhatReadsToThoseWhoDoNotDrive) {
  EXPECT_FALSE(relay_.only_reads(id_of("/a/target/set_parameters")));
  EXPECT_FALSE(relay_.only_reads(id_of("/a/target/set_light")));
  EXPECT_TRUE(relay_.only_reads(id_of("/a/target/get_parameters")));
  EXPECT_TRUE(relay_.only_reads(id_of("/a/target/list_parameters")));
  EXPECT_TRUE(relay_.only_reads(id_of("/a/target/describe_parameters")));
  EXPECT_TRUE(relay_.only_reads(1)) << "its own";
}

TEST_F(ServiceRelayOverDds, FailsACallOfWhatIsNotThere) {
  call(4711, {});
  EXPECT_EQ(failure(), "there is no service 4711");
  EXPECT_EQ(relay_.name(4711), "");
  call(1, {}, 7, "json");
  EXPECT_EQ(failure(), "the encoding must be cdr, not 'json'");
}

TEST_F(ServiceRelayOverDds, ReportsServicesThatHaveGone) {
  const std::uint32_t id = id_of("/a/target/set_light");
  set_light_.reset();
  json frame = json::object();
  EXPECT_TRUE(spin_until([&] {
    relay_.look({page_.id()});
    if (page_.has_frame()) frame = page_.read_json();
    return frame.value("op", "") == "unadvertiseServices";
  }));
  EXPECT_EQ(frame.at("serviceIds"), json::array({id}));
  call(id, {});
  EXPECT_EQ(failure(), "there is no service " + std::to_string(id));
}

// The node that offers the service is not spun, so nothing is answered.
TEST_F(ServiceRelayOverDds, BoundsCallsThatWaitAndTheirTime) {
  const std::uint32_t id = id_of("/a/target/set_light");
  for (std::uint32_t i = 0; i <= ServiceRelay::kMaxCalls; ++i)
    call(id, rt::encode(SetBool::Request{}), i);
  const json refused = page_.read_json();
  EXPECT_EQ(refused.at("message"), "too many calls are waiting for an answer");
  EXPECT_EQ(refused.at("callId"), ServiceRelay::kMaxCalls);
  for (int i = 0; i < ServiceRelay::kMaxCalls; ++i) {
    ASSERT_TRUE(test::spin_until([&] { return page_.has_frame(); },
                                 ServiceRelay::kTimeout + test::kTimeout, dashboard_));
    EXPECT_EQ(page_.read_json().at("message"), "no answer in time");
  }
  call(id, rt::encode(SetBool::Request{}));
  (void)payload_of(answer(), id);
}

}  // namespace
}  // namespace tandem
