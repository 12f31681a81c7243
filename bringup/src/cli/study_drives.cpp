// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/study_drives.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/cli/progress_bar.hpp"
#include "bringup/drive/parallel_drives.hpp"

namespace tandem {
namespace {

constexpr std::size_t kMaxSample = 40;  // drives

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// CPU time of this process and of its workers that have ended [h].
double cpu_hours() {
  double sum = 0.0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(whose, &usage);
    sum += seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  return sum / 3600.0;
}

// Measures what the drives cost on the first of them.
class CostSample {
 public:
  CostSample(const std::string& name, const DrivePlan& plan)
      : name_{name}, all_{plan.todo.size()}, left_{plan.sample}, jobs_{plan.jobs} {}

  // Whether the sample has just become complete.
  bool add(double cost) {
    ++count_;
    sum_ += cost;
    return --left_ == 0 && all_ > count_;
  }
  void print() const {
    const double hours = sum_ / static_cast<double>(count_) * static_cast<double>(all_) / 3600.0;
    std::fprintf(stderr,
                 "%s: %zu drives cost about %.2g CPU hours, measured on %zu; %.2g hours in %u "
                 "processes\n",
                 name_.c_str(), all_, hours, count_, hours / jobs_, jobs_);
  }

 private:
  std::string name_;
  std::size_t all_, left_, count_ = 0;
  unsigned jobs_;
  double sum_ = 0.0;  // [s]
};

}  // namespace

std::vector<std::size_t> unfinished(const Study& study, const StudyFolder& folder,
                                    const std::vector<std::size_t>& own) {
  std::vector<std::size_t> todo;
  for (const std::size_t i : own)
    if (!folder.results().contains(group_of(study, study.drives[i]), study.drives[i].seed))
      todo.push_back(i);
  return todo;
}

DrivePlan sample_first(const std::vector<std::size_t>& todo) {
  DrivePlan plan;
  plan.sample = std::clamp<std::size_t>(todo.size() / 20, 1, kMaxSample);
  const std::size_t step = std::max<std::size_t>(1, todo.size() / plan.sample);
  std::vector<std::size_t> rest;
  for (std::size_t k = 0; k < todo.size(); ++k) {
    const bool sampled = k % step == step / 2 && plan.todo.size() < plan.sample;
    (sampled ? plan.todo : rest).push_back(todo[k]);
  }
  plan.sample = plan.todo.size();
  std::shuffle(rest.begin(), rest.end(), std::mt19937{1});
  plan.todo.insert(plan.todo.end(), rest.begin(), rest.end());
  return plan;
}

void make_drives(const Study& study, StudyFolder& folder, const DrivePlan& plan) {
  if (plan.todo.empty()) return;
  Lockstep lockstep;  // each worker process gets its own copy by fork
  ProgressBar bar{plan.before + plan.todo.size(), plan.before, "drives"};
  CostSample cost{study.name, plan};
  long collisions = 0;
  work_side_by_side(
      plan.todo.size(), plan.jobs,
      [&](std::size_t i) {
        const StudyDrive& drive = study.drives[plan.todo[i]];
        try {
          return make_drive(study, drive, lockstep);
        } catch (const std::exception& error) {
          throw std::runtime_error(name_of(study, drive) + ": " + error.what());
        }
      },
      [&](std::size_t i, const nlohmann::json& finished) {
        folder.results().add(finished);
        collisions += finished.at("drive").at("collisions").get<long>();
        if (i < plan.sample && cost.add(finished.at("cost_s"))) {
          bar.clear();
          cost.print();
        }
        bar.step(fmt::format("{} collisions", collisions));
      });
  std::fprintf(stderr, "%s: %zu drives in %.3g CPU hours: %.0f drives per CPU hour\n",
               study.name.c_str(), plan.todo.size(), cpu_hours(),
               static_cast<double>(plan.todo.size()) / cpu_hours());
}

}  // namespace tandem
