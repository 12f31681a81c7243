// SPDX-License-Identifier: Apache-2.0
// sensing_faults [DRIVES [FIRST_SEED]]: drives with failing sensors on all cores (default 2000).
// Exit status 1 on a contact, or if a fault was not reported.
#include "closed_loop/sensing_faults.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace tandem::test {
namespace {

struct Result {
  int drives = 0, contacts = 0, unnamed = 0;
  double travelled = 0.0;
};

std::vector<Result> run(unsigned drives, unsigned first_seed) {
  const auto& faults = sensing_faults();
  std::vector<Result> results(faults.size());
  std::mutex mutex;
  std::atomic<unsigned> next{0};
  const auto work = [&] {
    for (unsigned i = next++; i < drives; i = next++) {
      const std::size_t kind = i % faults.size();
      const unsigned seed = first_seed + i / static_cast<unsigned>(faults.size());
      FaultyDrive drive{seed, faults[kind]};
      drive.run();
      const std::lock_guard lock{mutex};
      Result& result = results[kind];
      ++result.drives;
      result.contacts += static_cast<int>(drive.contacts());
      result.unnamed += drive.is_named() ? 0 : 1;
      result.travelled += drive.travelled();
      if (drive.contacts() > 0) std::printf("contact: %s, seed %u\n", faults[kind].name, seed);
    }
  };
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
    workers.emplace_back(work);
  workers.clear();
  return results;
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  using namespace tandem::test;
  const long drives = argc > 1 ? std::atol(argv[1]) : 2000;
  const long first = argc > 2 ? std::atol(argv[2]) : 1;
  if (drives < 1 || first < 0) {
    std::fprintf(stderr, "sensing_faults [DRIVES [FIRST_SEED]]: DRIVES must be 1 or more\n");
    return 2;
  }
  const auto results = run(static_cast<unsigned>(drives), static_cast<unsigned>(first));
  bool well = true;
  std::printf("%-26s %7s %9s %8s %12s\n", "fault", "drives", "contacts", "unnamed", "m per drive");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Result& r = results[i];
    std::printf("%-26s %7d %9d %8d %12.2f\n", sensing_faults()[i].name, r.drives, r.contacts,
                r.unnamed, r.travelled / std::max(1, r.drives));
    well = well && r.contacts == 0 && r.unnamed == 0;
  }
  return well ? 0 : 1;
}
