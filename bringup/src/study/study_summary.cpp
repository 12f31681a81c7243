// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_summary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <spdlog/fmt/fmt.h>

namespace tandem {
namespace {

constexpr double kTail = 0.025;   // probability beyond each end of the interval
constexpr double kNormal = 1.96;  // quantile 1 − kTail of the normal distribution

// Probability that at least `least` of n draws succeed, each with probability p.
double at_least(std::size_t least, std::size_t n, double p) {
  if (p >= 1.0) return 1.0;
  double sum = 0.0;
  for (std::size_t k = least; k <= n; ++k) {
    const auto real = static_cast<double>(k), all = static_cast<double>(n);
    sum +=
        std::exp(std::lgamma(all + 1.0) - std::lgamma(real + 1.0) - std::lgamma(all - real + 1.0) +
                 real * std::log(p) + (all - real) * std::log1p(-p));
  }
  return sum;
}

nlohmann::json json_of(const std::optional<Estimate>& estimate) {
  if (!estimate) return nullptr;
  return {{"value", estimate->value}, {"low", estimate->low}, {"high", estimate->high}};
}

// Keys of the measures in the JSON of a drive whose medians are summarized.
const char* const kMeasures[] = {"time_to_goal_s",
                                 "time_ratio",
                                 "path_ratio",
                                 "min_clearance_m",
                                 "mean_clearance_m",
                                 "obedience_rms",
                                 "agreement_direction",
                                 "agreement_direction_free",
                                 "agreement_magnitude",
                                 "stuck_s",
                                 "stick_travel_per_s",
                                 "stick_reversals",
                                 "jerk_rms",
                                 "angular_jerk_rms",
                                 "spectral_arc_length",
                                 "travel_reversals",
                                 "way_to_rest_m",
                                 "final_position_error_m",
                                 "final_heading_error_rad",
                                 "final_clearance_m"};

nlohmann::json medians(const std::vector<DriveResult>& drives) {
  const nlohmann::json all = drives;
  nlohmann::json medians;
  for (const char* name : kMeasures) {
    std::vector<double> values;
    for (const auto& drive : all) {
      const bool counts = std::string{name} != "time_to_goal_s" || drive.at("reached").get<bool>();
      if (counts && drive.at(name).is_number()) values.push_back(drive.at(name));
    }
    medians[name] = json_of(median_of(std::move(values)));
  }
  return medians;
}

template <class Value>
auto sum(const std::vector<DriveResult>& drives, Value value) {
  decltype(value(drives.front())) total{};
  for (const DriveResult& drive : drives) total += value(drive);
  return total;
}

template <class Test>
long count(const std::vector<DriveResult>& drives, Test test) {
  return std::count_if(drives.begin(), drives.end(), test);
}

bool reached(const DriveResult& drive) { return drive.reached; }
bool collided(const DriveResult& drive) { return drive.collisions > 0; }

nlohmann::json plan_times(const std::vector<DriveResult>& drives) {
  std::vector<double> p50, p95, p99;
  double longest = 0.0;
  for (const DriveResult& drive : drives) {
    if (drive.counts.plans == 0) continue;
    p50.push_back(drive.plan_ms.p50);
    p95.push_back(drive.plan_ms.p95);
    p99.push_back(drive.plan_ms.p99);
    longest = std::max(longest, drive.plan_ms.max);
  }
  if (p50.empty()) return nullptr;
  return {{"p50", quantiles(p50).p50},
          {"p95", quantiles(p95).p50},
          {"p99", quantiles(p99).p50},
          {"max", longest}};
}

// Mean BARN score of the drives that have one; null if none has.
nlohmann::json barn_score(const std::vector<DriveResult>& drives) {
  const auto scored = count(drives, [](const auto& d) { return d.barn_score.has_value(); });
  if (scored == 0) return nullptr;
  return sum(drives, [](const auto& d) { return d.barn_score.value_or(0.0); }) /
         static_cast<double>(scored);
}

nlohmann::json summary_of(const DriveGroup& group) {
  const auto& drives = group.drives;
  const auto n = static_cast<long>(drives.size());
  const long commands = sum(drives, [](const auto& d) { return d.counts.filter_commands; });
  const long changed = sum(drives, [](const auto& d) { return d.counts.filter_interventions; });
  const double driven = sum(drives, [](const auto& d) { return d.simulated_s; });
  const double stuck = sum(drives, [](const auto& d) { return d.stuck_s; });
  return {{"scenario", group.scenario},
          {"method", group.method},
          {"driver", group.driver},
          {"n", n},
          {"reached", count(drives, reached)},
          {"success", json_of(share_of(count(drives, reached), n))},
          {"collisions", sum(drives, [](const auto& d) { return d.collisions; })},
          {"drives_with_a_collision", count(drives, collided)},
          {"collision_share", json_of(share_of(count(drives, collided), n))},
          {"intervention_rate", commands > 0 ? nlohmann::json(static_cast<double>(changed) /
                                                              static_cast<double>(commands))
                                             : nlohmann::json(nullptr)},
          {"intervention_episodes",
           sum(drives, [](const auto& d) { return d.counts.filter_episodes; })},
          {"stuck_share", driven > 0.0 ? stuck / driven : 0.0},
          {"barn_score", barn_score(drives)},
          {"simulated_s", driven},
          {"plans", sum(drives, [](const auto& d) { return d.counts.plans; })},
          {"plan_fallbacks", sum(drives, [](const auto& d) { return d.counts.plan_fallbacks; })},
          {"missed_deadlines", sum(drives, [](const auto& d) { return d.missed_deadlines; })},
          {"plan_ms", plan_times(drives)},
          {"medians", medians(drives)}};
}

std::string text_of(const nlohmann::json& estimate, const char* format) {
  if (estimate.is_null()) return "-";
  return fmt::format(fmt::runtime(format), estimate.at("value").get<double>());
}

std::string degrees_of(const nlohmann::json& estimate) {
  if (estimate.is_null()) return "-";
  return fmt::format("{:.1f}°", estimate.at("value").get<double>() * 180.0 / std::numbers::pi);
}

std::string csv_quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string cell(const nlohmann::json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) return csv_quoted(value.get<std::string>());
  if (!value.is_array()) return value.dump();
  std::string all;
  for (const auto& item : value) all += (all.empty() ? "" : "; ") + item.get<std::string>();
  return csv_quoted(all);
}

// Appends names and values of all fields; nested names are written as outer.inner.
void flatten(const nlohmann::json& json, const std::string& prefix,
             std::vector<std::pair<std::string, std::string>>& out) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object())
      flatten(value, prefix + key + ".", out);
    else
      out.emplace_back(prefix + key, cell(value));
  }
}

}  // namespace

std::optional<Estimate> median_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size(), half = (n + 1) / 2;
  const auto bound = [&](double probability) {
    std::size_t k = 1;
    while (k < n &&
           at_least(half, n, static_cast<double>(k) / static_cast<double>(n)) < probability)
      ++k;
    return values[k - 1];
  };
  return Estimate{values[half - 1], bound(kTail), bound(1.0 - kTail)};
}

std::optional<Estimate> share_of(long part, long whole) {
  if (whole <= 0) return std::nullopt;
  const auto n = static_cast<double>(whole);
  const double p = static_cast<double>(part) / n, z2 = kNormal * kNormal;
  const double middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = kNormal * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n)) / (1.0 + z2 / n);
  return Estimate{p, std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::vector<DriveGroup> groups_of(const std::vector<DriveResult>& drives) {
  std::vector<DriveGroup> groups;
  for (const DriveResult& d : drives) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const DriveGroup& g) {
      return g.scenario == d.scenario && g.method == d.method && g.driver == d.driver;
    });
    if (group == groups.end())
      group = groups.insert(groups.end(), {d.scenario, d.method, d.driver, {}});
    group->drives.push_back(d);
  }
  return groups;
}

nlohmann::json summary_of(const std::vector<DriveGroup>& groups) {
  nlohmann::json all = nlohmann::json::array();
  for (const DriveGroup& group : groups) all.push_back(summary_of(group));
  return all;
}

std::string study_table(const std::vector<DriveGroup>& groups) {
  std::size_t width = 16;
  for (const DriveGroup& group : groups) width = std::max(width, group.scenario.size());
  std::string out = fmt::format(
      "{:<{}} {:<15} {:<22} {:>5} {:>8} {:>10} {:>7} {:>20} {:>6} {:>8} {:>9} {:>7} {:>7} {:>6} "
      "{:>7} {:>8} {:>6}\n",
      "scenario", width, "method", "driver", "n", "reached", "collisions", "drives", "time [95 %]",
      "ratio", "closest", "agreement", "stuck", "filter", "turned", "to rest", "off goal", "askew");
  for (const DriveGroup& group : groups) {
    const nlohmann::json s = summary_of(group);
    const auto& m = s.at("medians");
    const auto& time = m.at("time_to_goal_s");
    const std::string interval =
        time.is_null() ? "-"
                       : fmt::format("{:.1f} s [{:.1f}, {:.1f}]", time.at("value").get<double>(),
                                     time.at("low").get<double>(), time.at("high").get<double>());
    const auto& rate = s.at("intervention_rate");
    out += fmt::format(
        "{:<{}} {:<15} {:<22} {:>5} {:>8} {:>10} {:>7} {:>20} {:>6} {:>8} {:>9} {:>5.1f} % {:>7} "
        "{:>6} {:>7} {:>8} {:>6}\n",
        group.scenario, width, group.method, group.driver, s.at("n").get<long>(),
        s.at("reached").get<long>(), s.at("collisions").get<long>(),
        s.at("drives_with_a_collision").get<long>(), interval,
        text_of(m.at("time_ratio"), "{:.2f}"), text_of(m.at("min_clearance_m"), "{:.3f} m"),
        text_of(m.at("agreement_direction"), "{:.3f}"), 100.0 * s.at("stuck_share").get<double>(),
        rate.is_null() ? "-" : fmt::format("{:.2f} %", 100.0 * rate.get<double>()),
        text_of(m.at("travel_reversals"), "{:.0f}"), text_of(m.at("way_to_rest_m"), "{:.2f} m"),
        text_of(m.at("final_position_error_m"), "{:.3f} m"),
        degrees_of(m.at("final_heading_error_rad")));
  }
  for (const DriveGroup& group : groups)
    if (const auto score = barn_score(group.drives); !score.is_null())
      out += fmt::format("{} by {}, {}: BARN's score {:.3f}\n", group.scenario, group.method,
                         group.driver, score.get<double>());
  return out;
}

std::string cost_table(const std::vector<DriveResult>& drives) {
  std::vector<std::string> methods;
  for (const DriveResult& d : drives)
    if (std::find(methods.begin(), methods.end(), d.method) == methods.end())
      methods.push_back(d.method);
  std::string out =
      fmt::format("{:<15} {:>12} {:>10} {:>12} {:>8} {:>10} {:>10} {:>8} {:>8} {:>8} {:>9} {:>6}\n",
                  "method", "simulated", "CPU", "times real", "planner", "extractor", "simulator",
                  "filter", "person", "set-up", "measures", "rest");
  for (const auto& method : methods) {
    std::vector<DriveResult> own;
    for (const DriveResult& d : drives)
      if (d.method == method) own.push_back(d);
    const double simulated = sum(own, [](const auto& d) { return d.simulated_s; });
    const double cpu = sum(own, [](const auto& d) { return d.cpu_s; });
    const double wall = sum(own, [](const auto& d) { return d.part_s.setup + d.wall_s; });
    if (!(cpu > 0.0) || !(wall > 0.0)) continue;
    double rest = 100.0;
    const auto share = [&](double PartTimes::*part) {
      const double percent = 100.0 * sum(own, [&](const auto& d) { return d.part_s.*part; }) / wall;
      rest -= percent;
      return fmt::format("{:.1f} %", percent);
    };
    out += fmt::format(
        "{:<15} {:>10.0f} s {:>8.1f} s {:>12.0f} {:>8} {:>10} {:>10} {:>8} {:>8} {:>8} {:>9}",
        method, simulated, cpu, simulated / cpu, share(&PartTimes::planner),
        share(&PartTimes::extractor), share(&PartTimes::simulator), share(&PartTimes::filter),
        share(&PartTimes::person), share(&PartTimes::setup), share(&PartTimes::measures));
    out += fmt::format(" {:>4.1f} %\n", rest);
  }
  return out;
}

std::string csv_of(const std::vector<DriveResult>& drives) {
  std::string out;
  for (const DriveResult& drive : drives) {
    std::vector<std::pair<std::string, std::string>> fields;
    flatten(nlohmann::json(drive), "", fields);
    std::string names, values;
    for (const auto& [name, value] : fields) {
      names += (names.empty() ? "" : ",") + name;
      values += (&value == &fields.front().second ? "" : ",") + value;
    }
    if (out.empty()) out = names + "\r\n";
    out += values + "\r\n";
  }
  return out;
}

}  // namespace tandem
