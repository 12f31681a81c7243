// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/summary_table.hpp"

#include <spdlog/fmt/fmt.h>

namespace tandem {

std::string progress_line(const Progress& p) {
  return fmt::format(
      "t {:6.1f} s   speed {:5.2f} m/s   clearance {:4.2f} m   planner {:5.1f} ms   collisions {}",
      p.t, p.twist.v, p.clearance, p.plan_ms, p.collisions);
}

namespace {

double percent(long part, long whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string planner_column(const DriveResult& r) {
  if (r.counts.plans == 0) return "-";
  return fmt::format("{:.1f} / {:.1f} / {:.1f} / {:.1f}, {:.1f} % ({} of {} over budget)",
                     r.plan_ms.p50, r.plan_ms.p95, r.plan_ms.p99, r.plan_ms.max,
                     percent(r.counts.plan_fallbacks, r.counts.plans), r.counts.plan_overruns,
                     r.counts.plans);
}

}  // namespace

std::string summary_table(const std::vector<DriveResult>& results) {
  std::string out = fmt::format(
      "{:<16} {:<13} {:>4} {:>7} {:>8} {:>10} {:>8} {:>8} {:>8} {:>7} {:>7}  {}\n", "scenario",
      "method", "seed", "reached", "time", "collisions", "closest", "off goal", "path", "stuck",
      "filter", "planner ms p50 / p95 / p99 / max, fallbacks");
  for (const DriveResult& r : results)
    out += fmt::format(
        "{:<16} {:<13} {:>4} {:>7} {:>6.1f} s {:>10} {:>6.3f} m {:>6.3f} m {:>6.1f} m {:>5.1f} s "
        "{:>5.1f} %  "
        "{}\n",
        r.scenario, r.method, r.seed,
        r.reached            ? "yes"
        : r.failures.empty() ? "no"
                             : "NO",
        r.reached ? r.time_to_goal_s : r.simulated_s, r.collisions, r.min_clearance_m,
        r.final_position_error_m, r.path_length_m, r.stuck_s,
        percent(r.counts.filter_interventions, r.counts.filter_commands), planner_column(r));
  for (const DriveResult& r : results)
    for (const std::string& failure : r.failures)
      out += fmt::format("FAILED  {} by {}, seed {}: {}\n", r.scenario, r.method, r.seed, failure);
  return out;
}

}  // namespace tandem
