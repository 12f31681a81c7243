// SPDX-License-Identifier: Apache-2.0
// Drives through the forest while one link between two nodes is disturbed.
#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "support/paths.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::test {

/// What happens to a link from some moment of the drive on.
enum class LinkFault { kDelay, kLoss, kSilence, kReset };
inline constexpr LinkFault kLinkFaults[]{LinkFault::kDelay, LinkFault::kLoss, LinkFault::kSilence,
                                         LinkFault::kReset};

inline const char* name(LinkFault fault) {
  switch (fault) {
    case LinkFault::kDelay:
      return "delay";
    case LinkFault::kLoss:
      return "loss";
    case LinkFault::kSilence:
      return "silence";
    case LinkFault::kReset:
      return "silence for a while";
  }
  return "";
}

/// The links of the forest's system by the names of their topics.
inline const std::vector<std::string>& links() {
  static const std::vector<std::string> all{"/clock",
                                            "/odom",
                                            "/tf",
                                            "/octomap_binary",
                                            "/joy",
                                            "/cmd_vel_user",
                                            "/leader_pose",
                                            "/obstacles",
                                            "/cmd_vel_shared",
                                            "/planner/status",
                                            "/cmd_vel_arbitrated",
                                            "/safety_filter/status",
                                            "/cmd_vel"};
  return all;
}

struct LinkDrive {
  std::string link;
  LinkFault fault;
  std::string method;
  unsigned seed;
};

/// The drive with that number; numbers count through links, faults and methods first.
inline LinkDrive link_drive(unsigned number) {
  static const std::vector<std::string> methods{"leader", "intention", "safety_filter"};
  const auto next = [&number](std::size_t count) {
    const std::size_t digit = number % count;
    number /= static_cast<unsigned>(count);
    return digit;
  };
  const std::size_t link = next(links().size()), fault = next(std::size(kLinkFaults)),
                    method = next(methods.size());
  return {links()[link], kLinkFaults[fault], methods[method], number + 1};
}

/// Drives; a fault begins after 2 to 10 s, of strengths that are random, too.
inline DriveResult drive_with_fault(Lockstep& lockstep, const LinkDrive& drive) {
  Scenario scenario = load_scenario(source_path("bringup/scenarios/forest_task2.yaml"));
  scenario.duration = 30.0;
  if (drive.link == "/cmd_vel") {  // a plain Twist does not show its age: tests/README.md
    scenario.parameters["safety_filter"]["stamped"] = {"true", "this test"};
    scenario.parameters["diff_drive_sim"]["max_stamp_age"] = {"0.05", "this test"};
  }
  std::mt19937 random{drive.seed};
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double begins = between(2.0, 10.0), lasts = between(0.1, 3.0);
  rt::LinkFaults faults;
  if (drive.fault == LinkFault::kDelay) faults = {between(0.0, 0.5), between(0.0, 0.3), 0.0};
  if (drive.fault == LinkFault::kLoss) faults.loss = between(0.1, 0.9);
  if (drive.fault == LinkFault::kSilence || drive.fault == LinkFault::kReset) faults.loss = 1.0;
  std::optional<rt::Node> disturber;
  rt::Timer begin, end;
  const auto prepare = [&](const std::shared_ptr<rt::LocalBus>& bus) {
    disturber.emplace(rt::NodeOptions{.name = "disturber", .serves_tools = false, .bus = bus});
    begin = disturber->create_wall_timer(begins, [&, raw = bus.get()] {
      begin = {};
      raw->disturb(drive.link, faults);
    });
    if (drive.fault == LinkFault::kReset)
      end = disturber->create_wall_timer(begins + lasts, [&, raw = bus.get()] {
        end = {};
        raw->disturb(drive.link, {});
      });
  };
  return lockstep
      .drive(scenario, {.method = drive.method, .seed = drive.seed, .lockstep = true}, {}, prepare)
      .result;
}

}  // namespace tandem::test
