// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/tune_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "bringup/cli/progress_bar.hpp"
#include "bringup/drive/lockstep.hpp"
#include "bringup/drive/parallel_drives.hpp"
#include "bringup/study/tuning.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

struct TuneRequest {
  std::vector<std::string> files, methods, knobs;
  std::string seeds = "1-3", check_seeds = "101-105", out;
  int evaluations = 100;
  unsigned jobs = 2;
};

// The columns of the table: means over drives; collisions and not_reached are totals.
struct Summary {
  double cost = 0.0, time = 0.0, obedience = 0.0, changed = 0.0, stuck = 0.0;
  int collisions = 0, not_reached = 0;
};

class Study {
 public:
  Study(const TuneRequest& request, const SeedRange& seeds) : jobs_{request.jobs} {
    const auto [first, last] = seeds;
    for (const auto& file : request.files) {
      const Scenario scenario = load_scenario(file);
      check_robot(scenario);
      const auto methods =
          request.methods.empty() ? std::vector<std::string>{scenario.method} : request.methods;
      for (const auto& method : methods) {
        DriveOptions options;
        options.method = method;
        options.lockstep = true;
        check_drive(scenario, options);
        for (options.seed = first; options.seed <= last; ++options.seed)
          drives_.push_back({with_options(scenario, options), options});
        systems_.push_back(system_of(drives_.back().scenario, drives_.back().options));
      }
    }
  }

  [[nodiscard]] const std::vector<DriveJob>& drives() const { return drives_; }
  // One system per scenario and method.
  [[nodiscard]] const std::vector<System>& systems() const { return systems_; }

  // Runs the drives with these values. The mean times of the first call are the reference of all
  // calls.
  Summary run(const std::vector<Knob>& knobs, const std::vector<double>& values) {
    auto drives = drives_;
    for (DriveJob& drive : drives)
      for (std::size_t i = 0; i < knobs.size(); ++i)
        drive.scenario.parameters[knobs[i].component][knobs[i].name] = {
            knobs[i].is_integer ? fmt::format("{:.0f}", values[i])
                                : fmt::format("{:.6}", values[i]),
            "tune"};
    const auto results = run_side_by_side(drives, jobs_, [](const DriveJob& job) {
      return drive_in_lockstep(job.scenario, job.options).result;
    });
    if (reference_.empty()) reference_ = mean_times(results);
    return summary(results);
  }

 private:
  using Times = std::map<std::string, double>;

  static std::string key(const DriveResult& r) { return r.scenario + " " + r.method; }

  static Times mean_times(const std::vector<DriveResult>& results) {
    Times sum, count;
    for (const DriveResult& r : results) {
      sum[key(r)] += r.reached ? r.time_to_goal_s : r.simulated_s;
      count[key(r)] += 1.0;
    }
    for (auto& [name, time] : sum) time /= count[name];
    return sum;
  }

  [[nodiscard]] Summary summary(const std::vector<DriveResult>& results) const {
    Summary out;
    const double share = 1.0 / static_cast<double>(results.size());
    for (const DriveResult& r : results) {
      out.cost += share * drive_cost(r, reference_.at(key(r)));
      out.time += share * (r.reached ? r.time_to_goal_s : r.simulated_s);
      out.obedience += share * r.obedience_rms;
      out.stuck += share * r.stuck_s;
      out.changed += share * static_cast<double>(r.counts.filter_interventions) /
                     static_cast<double>(std::max(1L, r.counts.filter_commands));
      out.collisions += r.collisions;
      out.not_reached += r.reached ? 0 : 1;
    }
    return out;
  }

  unsigned jobs_;
  std::vector<DriveJob> drives_;
  std::vector<System> systems_;
  Times reference_;
};

void print_row(const char* what, const Summary& s) {
  std::printf("%-22s %8.4f %8.1f s %10.3f %8.2f %% %8.1f s %10d %11d\n", what, s.cost, s.time,
              s.obedience, 100.0 * s.changed, s.stuck, s.collisions, s.not_reached);
}

void print_head() {
  std::printf("%-22s %8s %10s %10s %10s %10s %10s %11s\n", "", "cost", "time", "obedience",
              "filter", "stuck", "collisions", "not reached");
}

void print_verdict(const std::vector<Summary>& others, const Tuned& tuned) {
  if (tuned.other_cost >= others.front().cost) {
    std::printf("\nNothing found is better for other persons too: the values stay as they are.\n");
    return;
  }
  std::printf("\nBest for persons that the search does not drive with:\n");
  print_head();
  print_row("now", others.front());
  for (const Summary& s : others)
    if (s.cost == tuned.other_cost) return print_row("tuned", s);
}

// The values as a ROS 2 parameter file, which any node accepts.
std::string parameter_file(const std::vector<Knob>& knobs, const std::vector<double>& values) {
  std::map<std::string, std::string> sections;
  for (std::size_t i = 0; i < knobs.size(); ++i)
    sections[knobs[i].component] += knobs[i].is_integer
                                        ? fmt::format("    {}: {:.0f}\n", knobs[i].name, values[i])
                                        : fmt::format("    {}: {:.4}\n", knobs[i].name, values[i]);
  std::string text;
  for (const auto& [component, lines] : sections)
    text += component + ":\n  ros__parameters:\n" + lines;
  return text;
}

// Called before the search, so that an unwritable file is reported at once. Leaves the file as it
// is until better values are found.
void check_writable(const std::string& out) {
  if (out.empty()) return;
  const fs::path folder = fs::path{out}.has_parent_path() ? fs::path{out}.parent_path() : ".";
  const fs::path written = fs::exists(out) ? fs::path{out} : folder;
  if (fs::is_directory(out) || access(written.c_str(), W_OK) != 0)
    throw std::invalid_argument("--out " + out +
                                ": cannot be written; name a file in a folder that exists");
}

[[nodiscard]] bool is_written(const std::string& out, const std::string& text) {
  if (out.empty()) return true;
  std::ofstream stream{out};
  stream << text;
  stream.close();
  return static_cast<bool>(stream);
}

void check_apart(const SeedRange& seeds, const SeedRange& check) {
  if (seeds.first <= check.last && check.first <= seeds.last)
    throw std::invalid_argument(
        fmt::format("--seeds {}-{} and --check-seeds {}-{} overlap: judge what is found by persons "
                    "that the search does not drive with",
                    seeds.first, seeds.last, check.first, check.last));
}

// Runs the search. Both cost functions print rows of the table.
Tuned search(const TuneRequest& request, const std::vector<Knob>& knobs, Study& study, Study& check,
             std::vector<Summary>& others) {
  int n = 0;
  double lowest = 1e300, lowest_other = 1e300;
  ProgressBar bar{static_cast<std::size_t>(request.evaluations), 0, "evaluations"};
  const auto print = [&](const std::string& what, const Summary& s) {
    bar.clear();
    print_row(what.c_str(), s);
    std::fflush(stdout);
  };
  const auto cost = [&](const std::vector<double>& values) {
    const Summary s = study.run(knobs, values);
    if (s.cost < lowest) print(n == 0 ? "now" : fmt::format("evaluation {}", n), s);
    lowest = std::min(lowest, s.cost);
    bar.step(fmt::format("lowest cost {:.4f}", lowest));
    ++n;
    return s.cost;
  };
  const auto other_cost = [&](const std::vector<double>& values) {
    others.push_back(check.run(knobs, values));
    print("  other persons", others.back());
    const double found = others.back().cost;
    const bool is_better = others.size() > 1 && found < lowest_other;  // the first is the baseline
    lowest_other = std::min(lowest_other, found);
    // Written at once, so that an interrupted search keeps its best values.
    if (is_better) (void)is_written(request.out, parameter_file(knobs, values));
    return found;
  };
  return tune(knobs, request.evaluations, cost, other_cost);
}

void run(const TuneRequest& request) {
  const SeedRange seeds = seed_range("--seeds", request.seeds),
                  check_seeds = seed_range("--check-seeds", request.check_seeds);
  check_apart(seeds, check_seeds);
  check_writable(request.out);
  Study study{request, seeds}, check{request, check_seeds};
  const std::vector<Knob> knobs = read_knobs(request.knobs, study.systems());

  std::printf("%zu drives per evaluation, %zu with other persons where it lowers the cost\n",
              study.drives().size(), check.drives().size());
  print_head();
  std::vector<Summary> others;  // the first is the baseline: the current values
  const Tuned tuned = search(request, knobs, study, check, others);
  print_verdict(others, tuned);
  const std::string text = parameter_file(knobs, tuned.values);
  std::printf("\n%s", text.c_str());
  std::fflush(stdout);
  if (!is_written(request.out, text))
    throw std::runtime_error("--out " + request.out + ": cannot be written; copy from above");
}

}  // namespace

void add_tune_command(CLI::App& app) {
  auto* command =
      app.add_subcommand("tune", "Search better values for parameters by driving scenarios");
  auto request = std::make_shared<TuneRequest>();
  command->add_option("files", request->files, "scenario files")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--vary", request->knobs,
                   "component.parameter[:low:high], e.g. local_planner.weight_x:1:20; repeat it")
      ->required();
  command->add_option("--method", request->methods, "methods to drive by; default: the scenario's");
  command->add_option("--seeds", request->seeds, "seeds to tune on, A-B")->capture_default_str();
  command->add_option("--check-seeds", request->check_seeds, "seeds to judge the result by, A-B")
      ->capture_default_str();
  command->add_option("--evaluations", request->evaluations, "how often all drives are made")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--jobs", request->jobs, "processes side by side")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--out", request->out,
                      "write the best values, as soon as they are found, to this parameter file");
  command->callback([request] { run(*request); });
}

}  // namespace tandem
