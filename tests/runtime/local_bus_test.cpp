// SPDX-License-Identifier: Apache-2.0
// Nodes on a LocalBus: the component of test_component.cpp, and what the bus promises.
#include "tandem/runtime/local_bus.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tandem/runtime/component.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Point;
using std_msgs::msg::Float64;
using Numbers = std::vector<double>;

constexpr rt::Topic<Float64> kIn{"in"}, kOut{"out", rt::kLatched}, kPings{"pings"};
constexpr rt::Topic<Point> kPoint{"in"};
constexpr rt::ServiceName<std_srvs::srv::SetBool> kSwitch{"switch"};

Float64 number(double value) {
  Float64 message;
  message.data(value);
  return message;
}

class LocalBus : public testing::Test {
 protected:
  rt::NodeOptions options(const std::string& name) {
    rt::NodeOptions made;
    made.name = name;
    made.bus = bus_;
    return made;
  }
  template <class M>
  rt::Subscription collect(rt::Node& node, const rt::Topic<M>& topic, Numbers& into) {
    return node.create_subscription(
        topic, [&into](const auto& message) { into.push_back(message.data()); });
  }

  std::shared_ptr<rt::LocalBus> bus_ = std::make_shared<rt::LocalBus>();
};

TEST_F(LocalBus, RunsAComponentAsItIs) {
  rt::NodeOptions doubled = options("doubler");
  doubled.parameters.values["factor"] = {"3.0", "test"};
  const auto component = rt::load_component("test_component", doubled);
  rt::Node node{options("test")};
  Numbers received;
  const auto out = collect(node, kOut, received);
  const auto in = node.create_publisher(kIn);
  in.publish(number(2.0));
  EXPECT_TRUE(received.empty());
  bus_->run_for(0.0);
  EXPECT_EQ(received, Numbers{6.0});
}

TEST_F(LocalBus, FiresTimersOnSimulatedTime) {
  rt::Node node{options("test")};
  Numbers at;
  const auto timer = node.create_timer(0.25, [&] { at.push_back(node.now()); });
  bus_->run_for(3600.0);
  EXPECT_EQ(at.size(), 14400U);
  EXPECT_EQ(at.front(), 0.25);
  EXPECT_EQ(bus_->now(), 3600.0);
  EXPECT_EQ(rt::to_seconds(node.stamp()), 1'000'003'600.0);
}

// What a timer publishes arrives before the next timer fires.
TEST_F(LocalBus, DeliversMessagesBeforeTheNextTimer) {
  rt::Node first{options("first")}, second{options("second")};
  std::string order;
  const auto out = first.create_publisher(kPings);
  const auto in = second.create_subscription(kPings, [&](const auto&) { order += "m"; });
  const auto a = first.create_timer(1.0, [&] { order += "a", out.publish(number(0.0)); });
  const auto b = second.create_timer(1.0, [&] { order += "b"; });
  bus_->run_for(2.0);
  EXPECT_EQ(order, "ambamb");
}

TEST_F(LocalBus, GivesNodesTheTimeOfTheirClock) {
  rt::NodeOptions simulated = options("simulated");
  simulated.use_sim_time = true;
  rt::Node master{options("master")}, node{simulated};
  const auto clock = master.create_publisher(rt::Topic<rosgraph_msgs::msg::Clock>{"/clock"});
  double published = 100.0;
  const auto tick = master.create_wall_timer(0.01, [&] {
    rosgraph_msgs::msg::Clock message;
    message.clock(rt::to_stamp(static_cast<std::int64_t>(1e9 * (published += 0.01))));
    clock.publish(message);
  });
  int fired = 0, jumps = 0;
  const auto timer = node.create_timer(0.1, [&] { ++fired; });
  const auto jump = node.on_time_jump([&] { ++jumps; });
  bus_->run_for(1.0);
  EXPECT_NEAR(node.now(), 101.0, 1e-6);
  EXPECT_NEAR(fired, 10, 1);
  EXPECT_FALSE(node.clock_is_silent());
  published = 1.0;
  bus_->run_for(0.5);
  EXPECT_EQ(jumps, 1);
  EXPECT_NEAR(node.now(), 1.5, 1e-6);
}

TEST_F(LocalBus, NoticesASilentClock) {
  rt::NodeOptions simulated = options("simulated");
  simulated.use_sim_time = true;
  const rt::Node node{simulated};
  bus_->run_for(0.4);
  EXPECT_FALSE(node.clock_is_silent());
  bus_->run_for(0.2);
  EXPECT_TRUE(node.clock_is_silent());
}

TEST_F(LocalBus, KeepsTheQosOfItsTopics) {
  rt::Node sender{options("sender")};
  const auto latched = sender.create_publisher(kOut);
  latched.publish(number(1.0));
  latched.publish(number(2.0));
  rt::Node receiver{options("receiver")};
  Numbers late, deep, weak;
  const auto last = collect(receiver, kOut, late);
  const auto newest = receiver.create_subscription(
      kPings, rt::QoS{.depth = 2}, [&](const auto& message) { deep.push_back(message.data()); });
  const auto best_effort = sender.create_publisher(kIn, rt::kBestEffort(5));
  const auto reliable = collect(receiver, kIn, weak);
  EXPECT_EQ(best_effort.matched(), 0);
  const auto pings = sender.create_publisher(kPings);
  for (int i = 1; i <= 5; ++i) pings.publish(number(i)), best_effort.publish(number(i));
  bus_->run_for(0.0);
  EXPECT_EQ(late, Numbers{2.0});
  EXPECT_EQ(deep, (Numbers{4.0, 5.0}));
  EXPECT_TRUE(weak.empty());
}

TEST_F(LocalBus, KeepsTypesOfOneNameApart) {
  rt::Node node{options("test")};
  Numbers numbers;
  const auto in = collect(node, kIn, numbers);
  const auto point = node.create_publisher(kPoint);
  EXPECT_EQ(point.matched(), 0);
  point.publish({});
  bus_->run_for(0.0);
  EXPECT_TRUE(numbers.empty());
  EXPECT_EQ(node.count_publishers("in"), 1U);
}

TEST_F(LocalBus, SerializesForThoseThatKnowATypeByNameOnly) {
  rt::Node node{options("test")};
  std::vector<std::uint8_t> bytes;
  Numbers numbers;
  const auto raw = node.create_generic_subscription(
      "in", "std_msgs/msg/Float64", rt::kDefault, [&](const auto& received) { bytes = received; });
  const auto typed = collect(node, kPings, numbers);
  const auto in = node.create_publisher(kIn);
  const auto relay = node.create_generic_publisher("pings", "std_msgs/msg/Float64", rt::kDefault);
  in.publish(number(4.5));
  bus_->run_for(0.0);
  relay.publish(bytes);
  relay.publish({1, 2, 3});
  bus_->run_for(0.0);
  EXPECT_EQ(numbers, Numbers{4.5});
  EXPECT_EQ(typed.malformed(), 1);
}

TEST_F(LocalBus, CallsServicesThatStartLater) {
  rt::Node client{options("client")}, server{options("server")};
  const auto asks = client.create_client(kSwitch);
  std_srvs::srv::SetBool_Request request;
  request.data(true);
  std::string answers;
  const auto answer = [&](const auto& response) { answers += response.message(); };
  asks.call(request, answer);
  asks.call(request, answer, 0.5, [&] { answers += "late "; });
  bus_->run_for(1.0);
  EXPECT_EQ(answers, "late ");
  const auto service = server.create_service(kSwitch, [](const auto& asked, auto& response) {
    response.message(asked.data() ? "on" : "off");
  });
  bus_->run_for(0.1);
  EXPECT_EQ(answers, "late on");
  EXPECT_TRUE(asks.ready());
}

TEST_F(LocalBus, SetsParametersByTheNodesServices) {
  const auto component = rt::load_component("test_component", options("doubler"));
  rt::Node node{options("test")};
  const auto get = node.create_client(
      rt::ServiceName<rcl_interfaces::srv::GetParameters>{"/doubler/get_parameters"});
  rcl_interfaces::srv::GetParameters_Request request;
  request.names({"use_sim_time"});
  int type = -1;
  get.call(request, [&](const auto& response) { type = response.values().at(0).type(); });
  bus_->run_for(0.1);
  EXPECT_EQ(type, 1);  // PARAMETER_BOOL
}

TEST_F(LocalBus, DelaysMessagesInOrder) {
  rt::Node node{options("test")};
  Numbers received;
  const auto in = collect(node, kIn, received);
  const auto out = node.create_publisher(kIn);
  bus_->disturb("/in", {.delay = 0.2});
  out.publish(number(1.0));
  bus_->disturb("/in", {});
  out.publish(number(2.0));
  bus_->disturb("/in", {.loss = 1.0});
  out.publish(number(3.0));
  bus_->run_for(0.19);
  EXPECT_TRUE(received.empty());
  bus_->run_for(0.02);
  EXPECT_EQ(received, (Numbers{1.0, 2.0}));
}

TEST_F(LocalBus, LosesTheSameBestEffortMessagesForTheSameSeedAndNoReliableOnes) {
  const auto drive = [](unsigned seed, const rt::QoS& qos) {
    const auto bus = std::make_shared<rt::LocalBus>(seed);
    rt::Node node{rt::NodeOptions{.name = "test", .bus = bus}};
    Numbers received;
    const auto in = node.create_subscription(
        kIn, qos, [&](const auto& message) { received.push_back(message.data()); });
    const auto out = node.create_publisher(kIn, qos);
    bus->disturb("", {.jitter = 0.03, .loss = 0.2});
    int sent = 0;
    const auto timer = node.create_timer(0.01, [&] {
      if (sent < 1000) out.publish(number(++sent));
    });
    bus->run_for(60.0);
    EXPECT_TRUE(std::is_sorted(received.begin(), received.end()));
    return received;
  };
  const rt::QoS best_effort = rt::kBestEffort(100), reliable{.depth = 1000};
  const Numbers some = drive(1, best_effort);
  EXPECT_GT(some.size(), 300U);
  EXPECT_LT(some.size(), 850U);
  EXPECT_EQ(some, drive(1, best_effort));
  EXPECT_NE(some, drive(2, best_effort));
  EXPECT_EQ(drive(1, reliable).size(), 1000U);
}

TEST_F(LocalBus, RefusesImpossibleFaults) {
  EXPECT_THROW(bus_->disturb("/in", {.delay = -0.1}), std::invalid_argument);
  EXPECT_THROW(bus_->disturb("/in", {.loss = 1.1}), std::invalid_argument);
}

TEST_F(LocalBus, WorksWithinTheInstant) {
  rt::Node node{options("test")};
  Numbers at;
  int left = 3;
  const auto worker = node.create_worker([&]() -> std::optional<double> {
    at.push_back(bus_->now());
    if (--left == 0) return std::nullopt;
    return left == 2 ? 0.0 : 0.5;
  });
  bus_->run_for(1.0);
  EXPECT_TRUE(at.empty());
  worker.wake();
  worker.wake();
  bus_->run_for(1.0);
  EXPECT_EQ(at, (Numbers{1.0, 1.0, 1.5}));
}

TEST_F(LocalBus, TellsThatAWorkerHasWorked) {
  rt::Node node{options("test")};
  std::string order;
  const auto worker = node.create_worker(
      [&] {
        order += "work ";
        return std::nullopt;
      },
      [&] { order += "told "; });
  worker.wake();
  bus_->run_for(0.0);
  worker.wake();
  bus_->run_for(0.0);
  EXPECT_EQ(order, "work told work told ");
}

TEST_F(LocalBus, TellsWhoPublishes) {
  rt::Node node{options("test")};
  std::vector<std::size_t> counts;
  const auto watch =
      node.watch_publishers(kIn, [&](const auto& offered) { counts.push_back(offered.size()); });
  auto out = node.create_publisher(kIn);
  bus_->run_for(0.0);
  const auto id = out.id();
  EXPECT_TRUE(node.is_present(id));
  out = {};
  bus_->run_for(0.0);
  EXPECT_EQ(counts, (std::vector<std::size_t>{1, 0}));
  EXPECT_FALSE(node.is_present(id));
}

TEST_F(LocalBus, EndsAnEndlessConversation) {
  rt::Node node{options("test")};
  const auto out = node.create_publisher(kIn);
  const auto in = node.create_subscription(kIn, [&](const auto& message) { out.publish(message); });
  out.publish(number(1.0));
  EXPECT_THROW(bus_->run_for(1.0), std::runtime_error);
}

TEST_F(LocalBus, SharesWhatNodesHaveComputed) {
  const auto cache = std::make_shared<rt::ResultCache>(2);
  int made = 0;
  // On a bus of its own each time, as in the drives of a study.
  const auto number_of = [&]<class T>(const std::string& key, T value) {
    rt::NodeOptions on_new_bus = options("test");
    on_new_bus.bus = std::make_shared<rt::LocalBus>(1, cache);
    rt::Node node{on_new_bus};
    return *node.cached<const T>(key, [&] { return ++made, std::make_shared<const T>(value); });
  };
  EXPECT_EQ(number_of("a", 1), 1);
  EXPECT_EQ(number_of("a", 2), 1) << "the result of the first call";
  EXPECT_EQ(number_of("a", 0.5), 0.5) << "another type";
  for (const char* key : {"b", "c", "d"}) (void)number_of(key, 0.5);
  EXPECT_EQ(number_of("a", 3), 1) << "results of another type displace none";
  EXPECT_EQ(number_of("a", 0.7), 0.7) << "forgotten: two of its type were used since";
  EXPECT_EQ(made, 6);
}

TEST_F(LocalBus, StopsANode) {
  rt::Node node{options("test")};
  int fired = 0;
  const auto timer = node.create_timer(0.1, [&] {
    if (++fired == 3) node.stop();
  });
  node.spin();
  EXPECT_NEAR(bus_->now(), 0.3, 1e-9);
  bus_->run_for(1.0);
  EXPECT_EQ(fired, 3);
}

}  // namespace
}  // namespace tandem
