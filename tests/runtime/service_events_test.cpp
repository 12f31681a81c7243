// SPDX-License-Identifier: Apache-2.0
// What nodes publish of their services' requests and responses, on both buses, as bytes: a service
// has no C++ type for its events.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/decode.hpp"
#include "tandem/runtime/detail/cdr_structure.hpp"
#include "tandem/runtime/local_bus.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using service_msgs::msg::ServiceEventInfo;
using std_srvs::srv::SetBool;
using Bytes = std::vector<std::uint8_t>;
namespace is = service_msgs::msg::ServiceEventInfo_Constants;

constexpr rt::ServiceName<SetBool> kWatched{"switch"};
constexpr std::size_t kInfoSize = 44;  // with the encapsulation header

struct Event {
  ServiceEventInfo info;
  Bytes rest;  // the sequences of requests and responses
};

Event event_of(const Bytes& bytes) {
  Event event;
  EXPECT_TRUE(decode(rt::type_ref<ServiceEventInfo>(), {bytes.begin(), bytes.begin() + kInfoSize},
                     &event.info));
  event.rest.assign(bytes.begin() + kInfoSize, bytes.end());
  return event;
}

// Sequences of a request {data: true} alone, of a response {success: true, message: "on"} alone.
const Bytes kNothing{0, 0, 0, 0, 0, 0, 0, 0};
const Bytes kRequest{1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
const Bytes kResponse{0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 'o', 'n', 0};

// A server and a client with introspection, and the events of their service.
class Introspection {
 public:
  Introspection(const std::string& state, std::shared_ptr<rt::LocalBus> bus)
      : server_{options("server", "service_configure_introspection", state, bus)},
        asker_{options("asker", "client_configure_introspection", state, bus)},
        spin_{[this, bus](const std::function<bool()>& done) {
          if (!bus) return test::spin_until(done, test::kTimeout, server_, asker_);
          bus->run_for(0.1);
          return done();
        }} {}

  // The events of one call, those of the server first.
  std::vector<Event> call() {
    SetBool::Request request;
    request.data(true);
    int answers = 0;
    client_.call(request, [&](const auto&) { ++answers; });
    EXPECT_TRUE(spin_([&] { return answers == 1 && events_.size() >= expected_; }));
    std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
      return is_of_server(a) && !is_of_server(b);
    });
    return std::exchange(events_, {});
  }
  void expect(std::size_t events) { expected_ = events; }
  // Waits until the node that watches is matched with both publishers of events.
  bool is_watched() {
    return spin_([this] { return server_.count_publishers("/switch/_service_event") == 2; });
  }
  rt::Node& server() { return server_; }
  bool spin(const std::function<bool()>& done) { return spin_(done); }

 private:
  static bool is_of_server(const Event& event) {
    return event.info.event_type() == is::REQUEST_RECEIVED ||
           event.info.event_type() == is::RESPONSE_SENT;
  }
  static rt::NodeOptions options(const std::string& name, const std::string& parameter,
                                 const std::string& state, std::shared_ptr<rt::LocalBus> bus) {
    rt::NodeOptions made{.name = name, .bus = std::move(bus)};
    made.parameters.values[parameter] = {state, "test"};
    return made;
  }

  rt::Node server_, asker_;
  std::function<bool(const std::function<bool()>&)> spin_;
  std::vector<Event> events_;
  std::size_t expected_ = 0;
  rt::Subscription subscription_ = server_.create_generic_subscription(
      "switch/_service_event", "std_srvs/srv/SetBool_Event", rt::kDefault,
      [this](const Bytes& bytes) { events_.push_back(event_of(bytes)); });
  rt::Service service_ = server_.create_service(kWatched, [](const auto& asked, auto& response) {
    response.success(asked.data());
    response.message("on");
  });
  rt::Client<SetBool> client_ = asker_.create_client(kWatched);
};

class ServiceEvents : public testing::TestWithParam<bool> {
 protected:
  static std::shared_ptr<rt::LocalBus> bus() {
    return GetParam() ? std::make_shared<rt::LocalBus>() : nullptr;
  }
};

TEST_P(ServiceEvents, TellOfRequestsAndResponsesAndTheirContents) {
  Introspection nodes{"contents", bus()};
  nodes.expect(4);
  ASSERT_TRUE(nodes.is_watched());
  const auto events = nodes.call();
  ASSERT_EQ(events.size(), 4U);
  const int types[]{is::REQUEST_RECEIVED, is::RESPONSE_SENT, is::REQUEST_SENT,
                    is::RESPONSE_RECEIVED};
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(int{events[i].info.event_type()}, types[i]);
    EXPECT_EQ(events[i].rest, i % 2 == 0 ? kRequest : kResponse);
    EXPECT_EQ(events[i].info.sequence_number(), events[0].info.sequence_number());
    EXPECT_GT(events[i].info.stamp().sec(), 0);
  }
  EXPECT_EQ(events[0].info.client_gid(), events[1].info.client_gid());
  EXPECT_EQ(events[2].info.client_gid(), events[3].info.client_gid());
  EXPECT_GT(nodes.call().at(0).info.sequence_number(), events[0].info.sequence_number());
}

TEST_P(ServiceEvents, LeaveContentsOutWhereOnlyMetadataIsAskedFor) {
  Introspection nodes{"metadata", bus()};
  nodes.expect(4);
  ASSERT_TRUE(nodes.is_watched());
  for (const Event& event : nodes.call()) EXPECT_EQ(event.rest, kNothing);
}

TEST_P(ServiceEvents, AreEnabledAndDisabledWhileTheNodeRuns) {
  Introspection nodes{"disabled", bus()};
  EXPECT_TRUE(nodes.call().empty());
  EXPECT_EQ(nodes.server().count_publishers("/switch/_service_event"), 0U);
  const auto set = [&](const std::string& state) {
    rcl_interfaces::msg::Parameter parameter;
    parameter.name("service_configure_introspection");
    parameter.value().type(4);  // a text
    parameter.value().string_value(state);
    rcl_interfaces::srv::SetParameters::Request request;
    request.parameters({parameter});
    std::string reason = "no answer";
    const auto client = nodes.server().create_client(
        rt::ServiceName<rcl_interfaces::srv::SetParameters>{"/server/set_parameters"});
    client.call(request, [&](const auto& answer) { reason = answer.results().at(0).reason(); });
    EXPECT_TRUE(nodes.spin([&] { return reason != "no answer"; }));
    return reason;
  };
  EXPECT_NE(set("everything").find("metadata"), std::string::npos);
  EXPECT_EQ(set("contents"), "");
  EXPECT_EQ(nodes.server().count_publishers("/switch/_service_event"), 1U);
  nodes.expect(2);
  EXPECT_EQ(nodes.call().size(), 2U);
  EXPECT_EQ(set("disabled"), "");
  EXPECT_EQ(nodes.server().count_publishers("/switch/_service_event"), 0U);
  nodes.expect(0);
  EXPECT_TRUE(nodes.call().empty());
}

INSTANTIATE_TEST_SUITE_P(OnBothBuses, ServiceEvents, testing::Bool(),
                         [](const auto& bus) { return bus.param ? "LocalBus" : "DDS"; });

// Fast CDR aligns the pose of a stamped pose by what stands before it.
TEST(CdrStructure, AppendsAMessageAsANestedStructureIsSerialized) {
  geometry_msgs::msg::PoseStamped stamped;
  stamped.pose().position().x(1.5);
  stamped.pose().orientation().z(-0.25);
  const auto pose = rt::encode(stamped.pose());
  const auto* structure = rt::CdrStructure::of("geometry_msgs/msg/Pose");
  for (std::size_t length = 0; length <= 8; ++length) {
    stamped.header().frame_id(std::string(length, 'x'));
    Bytes joined = rt::encode(stamped.header());
    ASSERT_TRUE(structure->append(pose, joined));
    EXPECT_EQ(joined, rt::encode(stamped)) << length;
  }
}

TEST(CdrStructure, AppendsTextsAndSequences) {
  sensor_msgs::msg::Joy joy;
  joy.header().frame_id("stick");
  joy.axes({0.5F, -1.0F, 0.25F});
  joy.buttons({1, 0});
  const auto bytes = rt::encode(joy);
  Bytes joined(4);
  ASSERT_TRUE(rt::CdrStructure::of("sensor_msgs/msg/Joy")->append(bytes, joined));
  EXPECT_EQ(Bytes(joined.begin() + 4, joined.end()), Bytes(bytes.begin() + 4, bytes.end()));
  Bytes cut{bytes.begin(), bytes.end() - 1};
  EXPECT_FALSE(rt::CdrStructure::of("sensor_msgs/msg/Joy")->append(cut, joined));
}

TEST(CdrStructure, AppendsBigEndianNumbersInLittleEndianOrder) {
  const Bytes big{0, 0, 0, 0, 0x3f, 0xf8, 0, 0, 0, 0, 0, 0};  // 1.5
  Bytes joined{0, 1, 0, 0};
  ASSERT_TRUE(rt::CdrStructure::of("std_msgs/msg/Float64")->append(big, joined));
  EXPECT_EQ(joined, (Bytes{0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f}));
}

}  // namespace
}  // namespace tandem
