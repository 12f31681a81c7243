// SPDX-License-Identifier: Apache-2.0
// Prints the cost of a message and of a timer on a local bus.
#include <benchmark/benchmark.h>

#include <memory>

#include "tandem/runtime/local_bus.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

template <class M>
void pass(benchmark::State& state, const M& message) {
  const auto bus = std::make_shared<rt::LocalBus>();
  rt::Node sender{rt::NodeOptions{.name = "sender", .bus = bus}};
  rt::Node receiver{rt::NodeOptions{.name = "receiver", .bus = bus}};
  constexpr rt::Topic<M> kTopic{"messages"};
  long received = 0;
  const auto in = receiver.create_subscription(kTopic, [&](const M&) { ++received; });
  const auto out = sender.create_publisher(kTopic);
  for (auto _ : state) {
    out.publish(message);
    bus->run_for(0.0);
  }
  if (received != state.iterations()) state.SkipWithError("messages were lost");
}

void twist(benchmark::State& state) { pass(state, geometry_msgs::msg::Twist{}); }
BENCHMARK(twist);

void map_of_100_kb(benchmark::State& state) {
  octomap_msgs::msg::Octomap map;
  map.data().resize(100'000);
  pass(state, map);
}
BENCHMARK(map_of_100_kb);

void timer(benchmark::State& state) {
  const auto bus = std::make_shared<rt::LocalBus>();
  rt::Node node{rt::NodeOptions{.name = "node", .bus = bus}};
  long fired = 0;
  const auto ticks = node.create_timer(0.01, [&] { ++fired; });
  for (auto _ : state) bus->run_for(0.01);
  benchmark::DoNotOptimize(fired);
}
BENCHMARK(timer);

}  // namespace
}  // namespace tandem

BENCHMARK_MAIN();
