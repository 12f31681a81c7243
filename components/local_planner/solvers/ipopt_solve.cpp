// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ipopt_solve.hpp"

#include <IpIpoptApplication.hpp>
#include <algorithm>
#include <memory>
#include <mutex>

#include "tandem/local_planner/solvers/ipopt_linear_solver.hpp"
#include "tandem/local_planner/solvers/ipopt_options.hpp"
#include "tandem/local_planner/solvers/ipopt_problem.hpp"
#include "tandem/local_planner/solvers/optimality.hpp"

namespace tandem {
namespace {

using Clock = std::chrono::steady_clock;
using Ipopt::GetRawPtr;
using Ipopt::SmartPtr;

constexpr int kPatience = 40;          // iterations after which a warm start counts as misleading
constexpr std::size_t kMaxSetups = 8;  // kept per thread

void set_options(Ipopt::OptionsList& options, LinearSolver linear, bool warm) {
  options.SetStringValue("sb", "yes");
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("nlp_scaling_method", "none");
  options.SetNumericValue("tol", kTolerance);
  options.SetNumericValue("constr_viol_tol", kTolerance);
  options.SetNumericValue("acceptable_tol", 1e-3);
  options.SetIntegerValue("acceptable_iter", 5);
  options.SetNumericValue("mu_target", kFinalBarrier);
  options.SetNumericValue("bound_relax_factor", 0.0);
  options.SetStringValue("linear_solver", linear == LinearSolver::kStages ? "ma27" : "mumps");
  if (linear == LinearSolver::kStages) {
    options.SetStringValue("linear_system_scaling", "none");
    options.SetIntegerValue("min_refinement_steps", 0);
    // The pivots are fixed, so a higher pivot tolerance would not improve the factors.
    options.SetNumericValue("ma27_pivtol", 1e-4);
    options.SetNumericValue("ma27_pivtolmax", 1e-4);
    // Ipopt's limit would count all solves of a setup and all threads; IpoptProblem checks the
    // deadline instead.
    options.SetNumericValue("max_cpu_time", 1e20);
  }
  if (!warm) {
    options.SetStringValue("mu_strategy", "adaptive");
    return;
  }
  options.SetStringValue("warm_start_init_point", "yes");
  options.SetNumericValue("mu_init", kFinalBarrier);
  // Small enough not to move an optimum, whose slacks are 1e-4 / multiplier.
  for (const char* push :
       {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
        "warm_start_slack_bound_frac", "warm_start_mult_bound_push"})
    options.SetNumericValue(push, 1e-9);
}

// --- with the stages' pivots ---------------------------------------------------------------------

// Shared by all setups of a thread. Not shared by threads, since Ipopt's object tags are per
// thread.
struct Common {
  SmartPtr<Ipopt::Journalist> journalist = new Ipopt::Journalist;
  SmartPtr<Ipopt::RegisteredOptions> registered = new Ipopt::RegisteredOptions;
  SmartPtr<RememberedOptions> cold = new RememberedOptions, warm = new RememberedOptions;

  Common() {
    Ipopt::IpoptApplication::RegisterAllIpoptOptions(registered);
    for (const bool is_warm : {false, true}) {
      RememberedOptions& options = is_warm ? *warm : *cold;
      options.SetJournalist(journalist);
      options.SetRegisteredOptions(registered);
      set_options(options, LinearSolver::kStages, is_warm);
    }
  }
};

// Ipopt, set up for problems of one structure.
class Setup {
 public:
  Setup(const Common& common, const Ocp& ocp, Structure structure, bool warm)
      : structure_{std::move(structure)},
        warm_{warm},
        options_{warm ? common.warm : common.cold},
        pivots_{stage_pivots(ocp)},
        problem_{new IpoptProblem(ocp)},
        app_{new Ipopt::IpoptApplication(common.registered, GetRawPtr(options_),
                                         common.journalist)} {
    // "": read no options file from the working directory.
    is_good_ = app_->Initialize("") == Ipopt::Solve_Succeeded;
  }

  [[nodiscard]] bool is_for(const Structure& structure, bool warm) const {
    return warm == warm_ && structure == structure_;
  }

  Solution solve(const Ocp& ocp, Bounds all, const Iterate& guess, const SolveLimits& limits);

 private:
  void set_option(const char* tag, int value) {
    int now = 0;
    options_->GetIntegerValue(tag, now, "");
    if (now != value) options_->SetIntegerValue(tag, value);
  }
  void set_option(const char* tag, bool value) {
    bool now = false;
    options_->GetBoolValue(tag, now, "");
    if (now != value) options_->SetStringValue(tag, value ? "yes" : "no");
  }

  Structure structure_;
  bool warm_;
  SmartPtr<RememberedOptions> options_;
  SparseLdl factors_;
  std::vector<Pivot> pivots_;
  SmartPtr<IpoptProblem> problem_;
  SmartPtr<Ipopt::IpoptApplication> app_;
  bool is_good_ = false;
  bool is_used_ = false;      // a solve has run
  bool has_factors_ = false;  // a solve got as far as a factorisation
};

Solution Setup::solve(const Ocp& ocp, Bounds all, const Iterate& guess, const SolveLimits& limits) {
  if (!is_good_) return {};
  const AsMa27 solver{factors_, pivots_};
  set_option("max_iter", limits.iterations);
  set_option("warm_start_same_structure", has_factors_);
  problem_->set(ocp, std::move(all), guess, limits);
  const SmartPtr<Ipopt::TNLP> problem{GetRawPtr(problem_)};
  const auto status = is_used_ ? app_->ReOptimizeTNLP(problem) : app_->OptimizeTNLP(problem);
  is_used_ = true;
  has_factors_ = has_factors_ || solver.is_used();
  return problem_->solution(status);
}

class Setups {
 public:
  Setup& get(const Ocp& ocp, const Structure& structure, bool warm) {
    auto found = std::find_if(setups_.begin(), setups_.end(),
                              [&](const auto& setup) { return setup->is_for(structure, warm); });
    if (found == setups_.end()) {
      if (setups_.size() == kMaxSetups) setups_.pop_back();
      found = setups_.insert(setups_.end(), std::make_unique<Setup>(common_, ocp, structure, warm));
    }
    std::rotate(setups_.begin(), found, found + 1);  // most recently used first
    return *setups_.front();
  }
  // To be called after a failure, which leaves the setup in an unknown state.
  void drop_latest() { setups_.erase(setups_.begin()); }

 private:
  Common common_;
  std::vector<std::unique_ptr<Setup>> setups_;
};

// A warm start gets at most kPatience iterations.
Solution solve_with_stages(const Ocp& ocp, const Bounds& all, const Structure& structure,
                           const Iterate& guess, const SolveLimits& limits) {
  thread_local Setups setups;
  const bool warm = !guess.lambda.empty();
  SolveLimits own = limits;
  if (warm) own.iterations = std::min(limits.iterations, kPatience);
  Solution solution = setups.get(ocp, structure, warm).solve(ocp, all, guess, own);
  if (solution.status == SolveStatus::kFailed) setups.drop_latest();
  return solution;
}

// --- with MUMPS ----------------------------------------------------------------------------------

std::timed_mutex& mumps_mutex() {
  static std::timed_mutex mutex;
  return mutex;
}

// A thread's applications for cold and warm starts. They are kept because building one, mainly its
// options, takes longer than a short solve.
class Applications {
 public:
  ~Applications() {
    const std::lock_guard lock{mumps_mutex()};  // destroys the last solve's MUMPS
    cold_ = warm_ = nullptr;
  }
  // Null if Ipopt fails to initialise.
  Ipopt::IpoptApplication* get(bool warm) {
    auto& app = warm ? warm_ : cold_;
    if (IsValid(app)) return GetRawPtr(app);
    app = new Ipopt::IpoptApplication(false);
    set_options(*app->Options(), LinearSolver::kMumps, warm);
    if (app->Initialize("") != Ipopt::Solve_Succeeded) app = nullptr;
    return GetRawPtr(app);
  }

 private:
  SmartPtr<Ipopt::IpoptApplication> cold_, warm_;
};

Solution solve_with_mumps(const Ocp& ocp, Bounds all, const Iterate& guess,
                          const SolveLimits& limits) {
  std::unique_lock lock{mumps_mutex(), std::defer_lock};
  if (limits.deadline == Clock::time_point::max())
    lock.lock();
  else if (!lock.try_lock_until(limits.deadline))
    return {.status = SolveStatus::kTimeout, .point = guess};

  thread_local Applications applications;
  Ipopt::IpoptApplication* app = applications.get(!guess.lambda.empty());
  if (app == nullptr) return {};
  app->Options()->SetIntegerValue("max_iter", limits.iterations);
  const SmartPtr<IpoptProblem> problem = new IpoptProblem(ocp);
  problem->set(ocp, std::move(all), guess, limits);
  // Not ReOptimizeTNLP: it would keep the first solve's clock and structure.
  return problem->solution(app->OptimizeTNLP(SmartPtr<Ipopt::TNLP>(GetRawPtr(problem))));
}

}  // namespace

LinearSolver best_linear_solver() {
  return takes_linear_solver() ? LinearSolver::kStages : LinearSolver::kMumps;
}

Solution ipopt_solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits,
                     LinearSolver linear) {
  Bounds all = bounds(ocp);
  if (linear == LinearSolver::kMumps) return solve_with_mumps(ocp, std::move(all), guess, limits);
  const Structure structure = structure_of(ocp, all);
  if (structure.fixed) return solve_with_mumps(ocp, std::move(all), guess, limits);

  const Solution first = solve_with_stages(ocp, all, structure, guess, limits);
  const bool is_cold = guess.lambda.empty(), is_late = first.iterations >= kPatience;
  const bool gave_up = first.status == SolveStatus::kTimeout && is_late && !is_cold;
  if (first.status != SolveStatus::kFailed && !gave_up) return first;
  SolveLimits rest = limits;
  rest.iterations -= first.iterations;
  if (rest.iterations <= 0) return first;
  Solution second = gave_up ? solve_with_stages(ocp, all, structure, {guess.z, {}, {}, {}}, rest)
                            : solve_with_mumps(ocp, std::move(all), guess, rest);
  second.iterations += first.iterations;
  return second;
}

}  // namespace tandem
