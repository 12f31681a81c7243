// SPDX-License-Identifier: Apache-2.0
// link_faults [DRIVES [FIRST]]: drives with disturbed links on all cores (default 10000). Exit
// status 1 on a collision.
#include "closed_loop/link_faults.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "bringup/drive/parallel_drives.hpp"

int main(int argc, char** argv) {
  using namespace tandem;
  const long drives = argc > 1 ? std::atol(argv[1]) : 10000;
  const long first = argc > 2 ? std::atol(argv[2]) : 0;
  if (drives < 1 || first < 0) {
    std::fprintf(stderr, "link_faults [DRIVES [FIRST]]: DRIVES must be 1 or more\n");
    return 2;
  }
  struct Row {
    int drives = 0, reached = 0, collisions = 0;
  };
  std::map<std::pair<std::string, std::string>, Row> rows;  // by fault and link
  Lockstep lockstep;
  const auto number = [&](std::size_t i) { return static_cast<unsigned>(first + long(i)); };
  work_side_by_side(
      static_cast<std::size_t>(drives), std::max(1u, std::thread::hardware_concurrency()),
      [&](std::size_t i) {
        return nlohmann::json(test::drive_with_fault(lockstep, test::link_drive(number(i))));
      },
      [&](std::size_t i, const nlohmann::json& result) {
        const auto drive = test::link_drive(number(i));
        Row& row = rows[{name(drive.fault), drive.link}];
        const int collisions = result.at("collisions");
        ++row.drives;
        row.reached += result.at("reached") ? 1 : 0;
        row.collisions += collisions;
        if (collisions > 0)
          std::printf("collision: drive %u, %s of %s, %s, seed %u\n", number(i), name(drive.fault),
                      drive.link.c_str(), drive.method.c_str(), drive.seed);
      });
  int collisions = 0;
  std::printf("%-20s %-22s %7s %8s %11s\n", "fault", "link", "drives", "arrived", "collisions");
  for (const auto& [key, row] : rows) {
    std::printf("%-20s %-22s %7d %8d %11d\n", key.first.c_str(), key.second.c_str(), row.drives,
                row.reached, row.collisions);
    collisions += row.collisions;
  }
  return collisions == 0 ? 0 : 1;
}
