// SPDX-License-Identifier: Apache-2.0
// wire_faults [DRIVES_PER_FAULT [FIRST_SEED [FAULT]]]: drives over DDS with faults of frames,
// stamps and QoS, 5 of each unless told. Exit status 1 on a contact, where a robot that should
// drive stood, and where a fault was not named.
#include "system/wire_faults.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace tandem::test {
namespace {

struct Result {
  int contacts = 0, stood = 0, not_as_wanted = 0;
  double travelled = 0.0, closest = 1.0;
};

Result drive(const WireFault& fault, int drives, unsigned first_seed) {
  Result result;
  for (int i = 0; i < drives; ++i) {
    const unsigned seed = first_seed + static_cast<unsigned>(i);
    WireDrive drive{seed, fault};
    drive.run();
    result.contacts += static_cast<int>(drive.contacts());
    result.stood += drive.has_driven() ? 0 : 1;
    result.not_as_wanted += drive.is_as_wanted() ? 0 : 1;
    result.travelled += drive.travelled() / drives;
    result.closest = std::min(result.closest, drive.closest());
    if (drive.contacts() > 0 || !drive.is_as_wanted())
      std::printf("  %s, seed %u: %u contacts, %.2f m: %s\n", fault.name.c_str(), seed,
                  drive.contacts(), drive.travelled(), drive.reasons().c_str());
  }
  return result;
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  using namespace tandem::test;
  const int drives = argc > 1 ? std::atoi(argv[1]) : 5;
  const long first = argc > 2 ? std::atol(argv[2]) : 1;
  const std::string only = argc > 3 ? argv[3] : "";
  if (drives < 1 || first < 0) {
    std::fprintf(stderr,
                 "wire_faults [DRIVES_PER_FAULT [FIRST_SEED [FAULT]]]: DRIVES_PER_FAULT must be 1 "
                 "or more\n");
    return 2;
  }
  bool well = true;
  std::printf("%-28s %7s %9s %6s %8s %12s %9s\n", "fault", "drives", "contacts", "stood", "unmet",
              "m per drive", "closest");
  for (const WireFault& fault : wire_faults()) {
    if (!only.empty() && fault.name != only) continue;
    const Result r = drive(fault, drives, static_cast<unsigned>(first));
    std::printf("%-28s %7d %9d %6d %8d %12.2f %7.3f m\n", fault.name.c_str(), drives, r.contacts,
                r.stood, r.not_as_wanted, r.travelled, r.closest);
    std::fflush(stdout);
    well = well && r.contacts == 0 && r.not_as_wanted == 0;
  }
  return well ? 0 : 1;
}
