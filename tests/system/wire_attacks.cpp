// SPDX-License-Identifier: Apache-2.0
// Attacks a running system by datagrams and prints what came of it, a line per kind:
//
//   wire_attacks [MUTATED [ANNOUNCED [SEED]]]
//
// MUTATED (10⁶) datagrams, counted as the guards receive them, are recorded ones, damaged: half of
// them of the running session, with the GUIDs and ports of its readers and writers, half of the
// files in tests/runtime/datagrams.
// ANNOUNCED (10⁵) announce participants and endpoints that do not exist. Exits 1 if a process
// ended, kept more memory than it may (20 MB, and 50 MB), or the robot did not drive or stop. Takes
// CAP_NET_RAW.
#include <cstdio>
#include <cstdlib>

#include "system/wire_attacks.hpp"

namespace tandem::test {
namespace {

int failures = 0;

void print_outcome(const char* kind, long tries, AttackedSystem& attacked, double most,
                   const std::string& more = "") {
  const bool alive = attacked.all_alive();
  const double growth = attacked.growth();
  const bool drives = attacked.system().wait_until_driving();
  std::printf("| %s | %ld | %s; at most %+.1f MB in a process; the robot %s%s |\n", kind, tries,
              alive ? "no process ended" : "A PROCESS ENDED", growth,
              drives ? "drives" : "DOES NOT DRIVE", more.c_str());
  std::fflush(stdout);
  if (!alive || growth > most || !drives) ++failures;
}

void replay_hostile_files(AttackedSystem& attacked) {
  const UdpSender stranger;
  const auto files = datagram_files("hostile");
  attacked.note_memory();
  for (const auto& file : files)
    for (int i = 0; i < 10; ++i) stranger.send_to_all(read(file), 16);
  print_outcome("the files of tests/runtime/datagrams/hostile, to every port",
                static_cast<long>(files.size()) * 10, attacked, 20.0);
}

// Until `count` have reached a guard; each round uses a new session.
void mutate(AttackedSystem& attacked, const LoopbackTap& tap, long count, unsigned seed) {
  attacked.note_memory();
  const double dropped = attacked.count("dropped"), start = rt::steady_seconds();
  constexpr long kRound = 20'000;
  long received = 0;
  while (received < count && attacked.all_alive()) {
    const auto session = tap.listen(1.0, 2000);
    if (session.empty()) break;
    received += attacked.send_mutated(std::min(kRound, count - received), session, seed++);
    std::fprintf(stderr, "%ld received, %.0f s, the robot at %.2f m/s\n", received,
                 rt::steady_seconds() - start, attacked.system().truth.twist.v);
  }
  const double duration = rt::steady_seconds() - start;
  (void)attacked.system().wait_until([] { return false; }, 2.0);  // the guards report each second
  char more[128];
  std::snprintf(more, sizeof more, "; %.0f dropped, whole or in part; %.0f a second",
                attacked.count("dropped") - dropped, static_cast<double>(received) / duration);
  print_outcome("mutated datagrams that the guards received, half of the running session", received,
                attacked, 20.0, more);
  if (received < count) ++failures;
}

void announce(AttackedSystem& attacked, long count) {
  attacked.note_memory();
  attacked.announce(count);
  const double start = rt::steady_seconds();
  ChildProcess newcomer{"peer", {"join"}};
  const auto joined = newcomer.wait(10.0);
  char more[128];
  std::snprintf(more, sizeof more, "; a real process joined %.1f s later",
                rt::steady_seconds() - start);
  if (joined != 0 || rt::steady_seconds() - start > 5.0) ++failures;
  print_outcome("announcements of participants and endpoints that do not exist", count, attacked,
                50.0, joined == 0 ? more : "; NO REAL PROCESS JOINED");
}

int attack(long mutated, long announced, unsigned seed) {
  const LoopbackTap tap;
  if (!tap.works()) {
    std::fprintf(stderr, "wire_attacks: no CAP_NET_RAW, so no session can be recorded\n");
    return 2;
  }
  AttackedSystem attacked;
  if (!attacked.system().wait_until_driving()) return 2;
  std::printf("| kind | tries | outcome |\n|---|---|---|\n");
  replay_hostile_files(attacked);
  announce(attacked, announced);
  mutate(attacked, tap, mutated, seed);
  const bool stops = attacked.stops();
  std::printf("| emergency stop after all that | 1 | the robot %s |\n",
              stops ? "stands" : "DOES NOT STAND");
  return failures == 0 && stops ? 0 : 1;
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  const auto argument = [&](int i, long usual) { return argc > i ? std::atol(argv[i]) : usual; };
  return tandem::test::attack(argument(1, 1'000'000), argument(2, 100'000),
                              static_cast<unsigned>(argument(3, 1)));
}
