// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_summary.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include <spdlog/fmt/fmt.h>

namespace tandem {
namespace {

constexpr double kTail = 0.025;   // probability beyond each end of the interval
constexpr double kNormal = 1.96;  // quantile 1 − kTail of the normal distribution

// Probability that exactly k of n draws succeed, each with probability p.
double exactly(std::size_t k, std::size_t n, double p) {
  const auto real = static_cast<double>(k), all = static_cast<double>(n);
  return std::exp(std::lgamma(all + 1.0) - std::lgamma(real + 1.0) - std::lgamma(all - real + 1.0) +
                  real * std::log(p) + (all - real) * std::log1p(-p));
}

// Probability that at least `least` of n draws succeed, each with probability p. Adds up the tail
// that does not contain the mean, whose terms decrease, until they no longer count.
double at_least(std::size_t least, std::size_t n, double p) {
  if (p >= 1.0) return 1.0;
  const bool above = static_cast<double>(least) > static_cast<double>(n) * p;
  double sum = 0.0;
  for (std::size_t k = above ? least : least - 1; k <= n; above ? ++k : --k) {  // 0 - 1 > n
    const double term = exactly(k, n, p);
    sum += term;
    if (term <= 1e-17 * sum) break;
  }
  return above ? sum : 1.0 - sum;
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

// The defined values of an expression over the drives of a group.
std::vector<double> values_of(const StudyResults& results, const DriveGroup& group,
                              const std::string& expression) {
  std::vector<double> values;
  results.select(group, expression, [&](const SqliteStatement& row) {
    if (sqlite3_column_type(row.get(), 0) != SQLITE_NULL)
      values.push_back(sqlite3_column_double(row.get(), 0));
  });
  return values;
}

nlohmann::json medians(const StudyResults& results, const DriveGroup& group) {
  nlohmann::json medians;
  for (const std::string name : kMeasures) {
    const bool counts_if_reached = name == "time_to_goal_s";
    medians[name] = json_of(median_of(values_of(
        results, group, counts_if_reached ? "CASE WHEN reached THEN " + name + " END" : name)));
  }
  return medians;
}

// Sums over the drives of a group; "n" is their number.
using Sums = std::map<std::string, double>;

Sums sums_of(const StudyResults& results, const DriveGroup& group) {
  static const std::vector<std::pair<std::string, std::string>> expressions{
      {"n", "count(*)"},
      {"reached", "sum(reached)"},
      {"collisions", "sum(collisions)"},
      {"collided", "sum(collisions > 0)"},
      {"commands", "sum(filter_commands)"},
      {"changed", "sum(filter_interventions)"},
      {"episodes", "sum(filter_episodes)"},
      {"driven", "sum(simulated_s)"},
      {"stuck", "sum(stuck_s)"},
      {"plans", "sum(plans)"},
      {"fallbacks", "sum(plan_fallbacks)"},
      {"missed", "sum(missed_deadlines)"},
      {"barn", "avg(barn_score)"},
      {"scored", "count(barn_score)"},
      {"longest_plan", "max(CASE WHEN plans > 0 THEN \"plan_ms.max\" END)"}};
  std::string columns;
  for (const auto& [name, expression] : expressions)
    columns += (columns.empty() ? "" : ", ") + expression;
  Sums sums;
  results.select(group, columns, [&](const SqliteStatement& row) {
    int index = 0;
    for (const auto& [name, expression] : expressions)
      sums[name] = sqlite3_column_double(row.get(), index++);
  });
  return sums;
}

// Medians over drives of each drive's quantiles, and the maximum; null without a plan.
nlohmann::json plan_times(const StudyResults& results, const DriveGroup& group, const Sums& sums) {
  if (sums.at("plans") <= 0.0) return nullptr;
  const auto middle = [&](const char* quantile) {
    return quantiles(
               values_of(results, group,
                         fmt::format("CASE WHEN plans > 0 THEN \"plan_ms.{}\" END", quantile)))
        .p50;
  };
  return {{"p50", middle("p50")},
          {"p95", middle("p95")},
          {"p99", middle("p99")},
          {"max", sums.at("longest_plan")}};
}

std::string finished_seeds(const StudyResults& results, const DriveGroup& group) {
  std::vector<unsigned> seeds;
  results.select(group, "seed", [&](const SqliteStatement& row) {
    seeds.push_back(static_cast<unsigned>(sqlite3_column_int64(row.get(), 0)));
  });
  return seed_ranges(seeds);
}

nlohmann::json summary_of(const StudyResults& results, const DriveGroup& group) {
  const Sums sums = sums_of(results, group);
  const auto whole = [&](const char* name) { return static_cast<long>(sums.at(name)); };
  const double commands = sums.at("commands"), driven = sums.at("driven");
  const auto or_null = [](bool defined, double value) {
    return defined ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  return {{"scenario", group.scenario},
          {"method", group.method},
          {"driver", group.driver},
          {"n", whole("n")},
          {"seeds", finished_seeds(results, group)},
          {"reached", whole("reached")},
          {"success", json_of(share_of(whole("reached"), whole("n")))},
          {"collisions", whole("collisions")},
          {"drives_with_a_collision", whole("collided")},
          {"collision_share", json_of(share_of(whole("collided"), whole("n")))},
          {"intervention_rate", or_null(commands > 0.0, sums.at("changed") / commands)},
          {"intervention_episodes", whole("episodes")},
          {"stuck_share", driven > 0.0 ? sums.at("stuck") / driven : 0.0},
          {"barn_score", or_null(sums.at("scored") > 0.0, sums.at("barn"))},
          {"simulated_s", driven},
          {"plans", whole("plans")},
          {"plan_fallbacks", whole("fallbacks")},
          {"missed_deadlines", whole("missed")},
          {"plan_ms", plan_times(results, group, sums)},
          {"medians", medians(results, group)}};
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
void flatten(const nlohmann::json& object, const std::string& prefix,
             std::vector<std::pair<std::string, std::string>>& out) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_object())
      flatten(value, prefix + key + ".", out);
    else
      out.emplace_back(prefix + key, cell(value));
  }
}

// In the order of their first groups.
std::vector<std::string> methods_of(const StudyFolder& folder) {
  std::vector<std::string> methods;
  for (const PlannedGroup& planned : folder.groups())
    if (std::find(methods.begin(), methods.end(), planned.group.method) == methods.end())
      methods.push_back(planned.group.method);
  return methods;
}

void for_each_drive(const StudyFolder& folder, const std::function<void(const DriveResult&)>& use) {
  for (const PlannedGroup& planned : folder.groups()) folder.results().read(planned.group, use);
}

}  // namespace

std::optional<Estimate> median_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size(), half = (n + 1) / 2;
  // The smallest k from 1 to n of at least this probability, which increases with k.
  const auto bound = [&](double probability) {
    std::size_t low = 1, high = n;
    while (low < high) {
      const std::size_t k = low + (high - low) / 2;
      if (at_least(half, n, static_cast<double>(k) / static_cast<double>(n)) < probability)
        low = k + 1;
      else
        high = k;
    }
    return values[low - 1];
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

nlohmann::json summary_of(const StudyFolder& folder) {
  nlohmann::json all = nlohmann::json::array();
  for (const PlannedGroup& planned : folder.groups()) {
    nlohmann::json summary = summary_of(folder.results(), planned.group);
    if (summary.at("n") > 0) all.push_back(std::move(summary));
  }
  return all;
}

std::string study_table(const nlohmann::json& summary) {
  std::size_t width = 16;
  for (const auto& s : summary)
    width = std::max(width, s.at("scenario").get_ref<const std::string&>().size());
  std::string out = fmt::format(
      "{:<{}} {:<15} {:<22} {:>5} {:>8} {:>10} {:>7} {:>20} {:>6} {:>8} {:>9} {:>7} {:>7} {:>6} "
      "{:>7} {:>8} {:>6}\n",
      "scenario", width, "method", "driver", "n", "reached", "collisions", "drives", "time [95 %]",
      "ratio", "closest", "agreement", "stuck", "filter", "turned", "to rest", "off goal", "askew");
  for (const auto& s : summary) {
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
        s.at("scenario").get<std::string>(), width, s.at("method").get<std::string>(),
        s.at("driver").get<std::string>(), s.at("n").get<long>(), s.at("reached").get<long>(),
        s.at("collisions").get<long>(), s.at("drives_with_a_collision").get<long>(), interval,
        text_of(m.at("time_ratio"), "{:.2f}"), text_of(m.at("min_clearance_m"), "{:.3f} m"),
        text_of(m.at("agreement_direction"), "{:.3f}"), 100.0 * s.at("stuck_share").get<double>(),
        rate.is_null() ? "-" : fmt::format("{:.2f} %", 100.0 * rate.get<double>()),
        text_of(m.at("travel_reversals"), "{:.0f}"), text_of(m.at("way_to_rest_m"), "{:.2f} m"),
        text_of(m.at("final_position_error_m"), "{:.3f} m"),
        degrees_of(m.at("final_heading_error_rad")));
  }
  for (const auto& s : summary)
    if (const auto& score = s.at("barn_score"); !score.is_null())
      out += fmt::format("{} by {}, {}: BARN's score {:.3f}\n", s.at("scenario").get<std::string>(),
                         s.at("method").get<std::string>(), s.at("driver").get<std::string>(),
                         score.get<double>());
  return out;
}

std::string cost_table(const StudyFolder& folder) {
  std::string out =
      fmt::format("{:<15} {:>12} {:>10} {:>12} {:>8} {:>10} {:>10} {:>8} {:>8} {:>8} {:>9} {:>6}\n",
                  "method", "simulated", "CPU", "times real", "planner", "extractor", "simulator",
                  "filter", "person", "set-up", "measures", "rest");
  for (const std::string& method : methods_of(folder)) {
    std::vector<double> sums;
    folder.results().query(
        "SELECT sum(simulated_s), sum(cpu_s), sum(\"part_s.setup\" + wall_s),"
        " sum(\"part_s.planner\"), sum(\"part_s.extractor\"), sum(\"part_s.simulator\"),"
        " sum(\"part_s.filter\"), sum(\"part_s.person\"), sum(\"part_s.setup\"),"
        " sum(\"part_s.measures\") FROM drives WHERE method = ?",
        {method}, [&](const SqliteStatement& row) {
          for (int i = 0; i < sqlite3_column_count(row.get()); ++i)
            sums.push_back(sqlite3_column_double(row.get(), i));
        });
    const double simulated = sums[0], cpu = sums[1], wall = sums[2];
    if (!(cpu > 0.0) || !(wall > 0.0)) continue;
    out += fmt::format("{:<15} {:>10.0f} s {:>8.1f} s {:>12.0f}", method, simulated, cpu,
                       simulated / cpu);
    double rest = 100.0;
    static constexpr int kWidths[] = {8, 10, 10, 8, 8, 8, 9};
    for (std::size_t part = 0; part < std::size(kWidths); ++part) {
      const double percent = 100.0 * sums[3 + part] / wall;
      rest -= percent;
      out += fmt::format(" {:>{}}", fmt::format("{:.1f} %", percent), kWidths[part]);
    }
    out += fmt::format(" {:>4.1f} %\n", rest);
  }
  return out;
}

std::string csv_of(const StudyFolder& folder) {
  std::string out;
  for_each_drive(folder, [&](const DriveResult& drive) {
    std::vector<std::pair<std::string, std::string>> fields;
    flatten(nlohmann::json(drive), "", fields);
    std::string names, values;
    for (const auto& [name, value] : fields) {
      names += (names.empty() ? "" : ",") + name;
      values += (&value == &fields.front().second ? "" : ",") + value;
    }
    if (out.empty()) out = names + "\r\n";
    out += values + "\r\n";
  });
  return out;
}

std::string json_of(const StudyFolder& folder) {
  std::string out = "[";
  for_each_drive(folder, [&](const DriveResult& drive) {
    out += (out.size() == 1 ? "\n" : ",\n") + nlohmann::json(drive).dump(1);
  });
  return out + "\n]\n";
}

nlohmann::json origins_of(const StudyFolder& folder) {
  nlohmann::json all = nlohmann::json::array();
  folder.results().query(
      "SELECT build, machine, count(*) FROM drives GROUP BY 1, 2 ORDER BY 3 DESC, 1, 2", {},
      [&](const SqliteStatement& row) {
        all.push_back({{"build", sql::text(row, 0)},
                       {"machine", sql::text(row, 1)},
                       {"drives", sqlite3_column_int64(row.get(), 2)}});
      });
  return all;
}

}  // namespace tandem
