// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlopt.hpp>
#include <optional>
#include <stdexcept>

#include "bringup/scenario/scenario.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/teleop/teleop_node.hpp"

namespace tandem {
namespace {

constexpr double kWide = 5.0;        // default bounds: start / kWide to kWide · start
constexpr double kFirstStep = 0.25;  // initial step, as a share of the unit interval

// Finds one number among the fields of a parameter struct.
struct NumberFinder {
  std::string wanted;
  std::optional<Knob>& found;

  void operator()(const char* name, double value, const Range& range, const char*) const {
    if (wanted == name) found = Knob{"", wanted, range.min, range.max, value, false};
  }
  void operator()(const char* name, int value, const Range& range, const char*) const {
    if (wanted == name)
      found = Knob{"", wanted, range.min, range.max, static_cast<double>(value), true};
  }
  void operator()(const char*, const std::string&, const OneOf&, const char*) const {}
  void operator()(const char*, const std::vector<double>&, const Range&, const char*) const {}
  void operator()(const char*, const std::vector<std::string>&, const OneOf&, const char*) const {}
  void operator()(const char*, bool, const char*) const {}
  void operator()(const char*, const std::string&, const char*) const {}
};

template <class Params>
std::optional<Knob> find_number(const System& system, const std::string& component,
                                const std::string& name) {
  std::optional<Knob> found;
  auto params = parameters_of<Params>(system, component);
  params.visit(NumberFinder{name, found});
  return found;
}

std::optional<Knob> find_number(const System& system, const std::string& component,
                                const std::string& name) {
  if (component == "local_planner")
    return find_number<LocalPlannerNodeParams>(system, component, name);
  if (component == "obstacle_extractor")
    return find_number<ObstacleExtractorNodeParams>(system, component, name);
  if (component == "teleop") return find_number<TeleopNodeParams>(system, component, name);
  throw std::invalid_argument("'" + component +
                              "' is not one of local_planner, obstacle_extractor, teleop");
}

// Whether the component affects a drive. Only the planner uses the extractor's shapes.
bool uses(const System& system, const std::string& component) {
  const std::string user = component == "obstacle_extractor" ? "local_planner" : component;
  return std::any_of(system.nodes.begin(), system.nodes.end(),
                     [&](const SystemNode& node) { return node.component == user; });
}

std::string component_of(const std::string& text) { return text.substr(0, text.find('.')); }

// Maps a value to [0, 1] within its bounds; from_unit is the inverse.
double to_unit(const Knob& knob, double value) {
  if (knob.low > 0.0) return std::log(value / knob.low) / std::log(knob.high / knob.low);
  return (value - knob.low) / (knob.high - knob.low);
}

double from_unit(const Knob& knob, double u) {
  const double value = knob.low > 0.0 ? knob.low * std::pow(knob.high / knob.low, u)
                                      : knob.low + u * (knob.high - knob.low);
  return std::clamp(knob.is_integer ? std::round(value) : value, knob.low, knob.high);
}

}  // namespace

Knob read_knob(const std::string& text, const System& system) {
  const auto colon = text.find(':');
  const std::string path = text.substr(0, colon);
  const auto dot = path.find('.');
  if (dot == std::string::npos)
    throw std::invalid_argument("'" + text + "': expected component.parameter[:low:high]");
  const std::string component = path.substr(0, dot), name = path.substr(dot + 1);
  auto knob = find_number(system, component, name);
  if (!knob)
    throw std::invalid_argument("'" + text + "': " + component + " has no number '" + name +
                                "'; see tandem describe " + component);
  if (!uses(system, component))
    throw std::invalid_argument("'" + text + "': no method that is driven uses " + component +
                                "; name one that does by --method");
  knob->component = component;
  const double lowest = knob->low, highest = knob->high;
  if (colon == std::string::npos) {
    if (knob->start <= 0.0)
      throw std::invalid_argument("'" + text + "' is " + std::to_string(knob->start) +
                                  " now: name its bounds, :low:high");
    knob->low = std::max(lowest, knob->start / kWide);
    knob->high = std::min(highest, knob->start * kWide);
  } else {
    char rest = '\0';
    if (std::sscanf(text.c_str() + colon, ":%lf:%lf%c", &knob->low, &knob->high, &rest) != 2)
      throw std::invalid_argument("'" + text + "': expected component.parameter[:low:high]");
  }
  if (!(knob->low >= lowest && knob->low < knob->high && knob->high <= highest))
    throw std::invalid_argument("'" + text + "': bounds must be increasing and within [" +
                                std::to_string(lowest) + ", " + std::to_string(highest) + "]");
  if (!(knob->start >= knob->low && knob->start <= knob->high))
    throw std::invalid_argument("'" + text + "' is " + std::to_string(knob->start) +
                                " now: name bounds that hold it, the search begins there");
  return *knob;
}

std::vector<Knob> read_knobs(const std::vector<std::string>& texts,
                             const std::vector<System>& systems) {
  std::vector<Knob> knobs;
  for (const auto& text : texts) {
    const auto system = std::find_if(systems.begin(), systems.end(), [&](const System& one) {
      return uses(one, component_of(text));
    });
    const Knob knob = read_knob(text, system == systems.end() ? systems.front() : *system);
    for (const Knob& other : knobs)
      if (other.component == knob.component && other.name == knob.name)
        throw std::invalid_argument("'" + text + "': " + knob.component + "." + knob.name +
                                    " is varied already; name it once");
    knobs.push_back(knob);
  }
  return knobs;
}

double drive_cost(const DriveResult& drive, double reference_time) {
  const double changed = drive.counts.filter_commands == 0
                             ? 0.0
                             : static_cast<double>(drive.counts.filter_interventions) /
                                   static_cast<double>(drive.counts.filter_commands);
  const double time = drive.reached ? drive.time_to_goal_s : drive.simulated_s;
  return time / reference_time + drive.obedience_rms + 2.0 * changed + 0.1 * drive.stuck_s +
         10.0 * drive.collisions + (drive.reached ? 0.0 : 10.0);
}

Tuned tune(const std::vector<Knob>& knobs, int evaluations, const Cost& cost,
           const Cost& other_cost) {
  std::vector<double> u;
  for (const Knob& knob : knobs) u.push_back(to_unit(knob, knob.start));
  const auto values_at = [&](const std::vector<double>& at) {
    std::vector<double> values;
    for (std::size_t i = 0; i < knobs.size(); ++i) values.push_back(from_unit(knobs[i], at[i]));
    return values;
  };
  Tuned best{values_at(u), cost(values_at(u)), other_cost(values_at(u))};
  if (evaluations < 2) return best;

  double lowest = best.cost;
  const std::function<double(const std::vector<double>&)> rated =
      [&](const std::vector<double>& at) {
        const auto values = values_at(at);
        const double c = cost(values);
        if (c >= lowest) return c;
        lowest = c;
        const double other = other_cost(values);
        if (other < best.other_cost) best = {values, c, other};
        return c;
      };
  nlopt::opt search{nlopt::LN_SBPLX, static_cast<unsigned>(knobs.size())};
  search.set_min_objective([](const std::vector<double>& at, std::vector<double>&,
                              void* data) { return (*static_cast<decltype(rated)*>(data))(at); },
                           const_cast<std::function<double(const std::vector<double>&)>*>(&rated));
  search.set_lower_bounds(0.0);
  search.set_upper_bounds(1.0);
  search.set_initial_step(kFirstStep);
  search.set_maxeval(evaluations - 1);
  search.set_xtol_abs(1e-3);
  double last = 0.0;
  try {
    search.optimize(u, last);
  } catch (const nlopt::roundoff_limited&) {  // no further progress is possible; the best is kept
  }
  return best;
}

}  // namespace tandem
