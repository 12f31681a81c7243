// SPDX-License-Identifier: Apache-2.0
// libFuzzer's input as a datagram: the guard reads nothing outside of it, and what it lets pass it
// also lets pass after its watches changed it. Made by tests/runtime/fuzz_guard.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "tandem/runtime/detail/announcements.hpp"
#include "tandem/runtime/detail/reader_progress.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"
#include "tandem/runtime/detail/server_restarts.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tandem::runtime;
  static ReaderProgress progress;
  static Announcements announcements;
  static ServerRestarts restarts;
  static double now = 0.0;
  std::vector<std::uint8_t> datagram(data, data + size);
  progress.sent(datagram, now);
  (void)check_datagram(datagram, {.all_protected = true});
  if (check_datagram(datagram, {}) != Drop::kNone) return 0;
  (void)announces_participant(datagram);
  std::vector<std::uint8_t> of_server = datagram;
  std::fill_n(of_server.begin() + rtps_message::kPrefixAt, rtps_message::kPrefixSize, 1);
  (void)restarts.are_shown_by(of_server, size % 3, now);  // from three ports
  (void)progress.narrow(datagram, now);
  (void)announcements.thin(datagram, now += 0.001);
  if (check_datagram(datagram, {}) != Drop::kNone) std::abort();
  return 0;
}
