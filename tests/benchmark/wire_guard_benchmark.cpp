// SPDX-License-Identifier: Apache-2.0
// Prints the RTPS guard's cost for a datagram of 200 bytes, as Fast DDS sends for an Odometry:
// INFO_DST, INFO_TS, DATA, HEARTBEAT, statistics.
#include <benchmark/benchmark.h>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/announcements.hpp"
#include "tandem/runtime/detail/reader_progress.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem {
namespace {

using namespace runtime;

test::Octets usual(std::int64_t number) {
  const test::Octets prefix(12, 5);
  return test::Datagram{}
      .vendor(0x010f)
      .add_destination(prefix)
      .add(0x09, 0, test::Octets(8, 1))
      .add_data({.reader = 0x00001204, .number = number}, test::Octets(36, 1))
      .add_heartbeat(number, number)
      .add(0x80, 0, test::Octets(56, 0))
      .octets();
}

void check_alone(benchmark::State& state) {
  const auto datagram = usual(7);
  for (auto _ : state) benchmark::DoNotOptimize(check_datagram(datagram, {}));
  state.SetLabel(std::to_string(datagram.size()) + " bytes");
}
BENCHMARK(check_alone);

// With writers that are followed, as many as the argument.
void check_and_watch(benchmark::State& state) {
  ReaderProgress progress;
  Announcements announcements;
  auto datagram = usual(7);
  for (int i = 0; i < state.range(0); ++i) {
    datagram[19] = static_cast<std::uint8_t>(i);
    datagram[18] = static_cast<std::uint8_t>(i >> 8);
    benchmark::DoNotOptimize(progress.narrow(datagram, 1.0));
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(check_datagram(datagram, {}));
    benchmark::DoNotOptimize(progress.narrow(datagram, 1.0));
    benchmark::DoNotOptimize(announcements.thin(datagram, 1.0));
  }
}
BENCHMARK(check_and_watch)->Arg(1)->Arg(1000);

}  // namespace
}  // namespace tandem

BENCHMARK_MAIN();
