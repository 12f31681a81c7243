// SPDX-License-Identifier: Apache-2.0
// Times solves of problems recorded along closed loops, each from the warm start that it had there.
// In script B.2 each solver drives its own loop; the other loops are driven by the Riccati interior
// point, and all solvers get the same problems. Rows: <solver>/<problem>/<parameters>.
#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "local_planner/drive.hpp"
#include "tandem/local_planner/cycle.hpp"
#include "tandem/local_planner/solvers/ipopt_solve.hpp"
#include "tandem/local_planner/solvers/solver.hpp"
#include "tandem/local_planner/warm_start.hpp"

namespace tandem::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Recorded {
  Ocp ocp;
  Iterate guess;
  std::vector<Pair> checked = {};  // against the solution
};
struct Recording {
  std::vector<Recorded> problems;
  double closed_loop_cost = 0.0;  // of the script's own form, heading error squared; 0: not summed
};

// --- solvers -------------------------------------------------------------------------------------

struct Structured {
  RiccatiSolver solver = {};
  const Solution& operator()(const Ocp& ocp, const Iterate& guess) {
    return solver.solve(ocp, guess, {.iterations = 300});
  }
};

struct Ipopt {
  Solution operator()(const Ocp& ocp, const Iterate& guess) {
    return ipopt_solve(ocp, guess, {.iterations = 300});
  }
};

struct IpoptWithMumps {
  Solution operator()(const Ocp& ocp, const Iterate& guess) {
    return ipopt_solve(ocp, guess, {.iterations = 300}, LinearSolver::kMumps);
  }
};

struct Certified {
  Solver solver{SolverKind::kCertified};
  Solution operator()(const Ocp& ocp, const Iterate& guess) {
    Answer answer = solver.solve(ocp, guess, {.iterations = 300});
    if (answer.verdict != Verdict::kConfirmed) answer.solution.status = SolveStatus::kAcceptable;
    return answer.solution;
  }
};

// --- problems ------------------------------------------------------------------------------------

constexpr double kMissed = 1e-4;  // [m] of a distance, as the solvers keep their constraints

using Pairs = std::vector<Pair>;

// Those that the motion comes nearer to than their gap, at the end of any stage. Round obstacles.
Pairs missed(const Ocp& ocp, const Iterate& point, const Pairs& checked) {
  Pairs out;
  for (const Pair& pair : checked) {
    const double least = pair.gap + pair.obstacle.a - kMissed;
    bool is_missed = false;
    for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
      const Eigen::Vector2d p_MB = pose_after(ocp, point.z, k).position();
      is_missed = is_missed || (pair.obstacle.p_MO - p_MB).squaredNorm() < least * least;
    }
    if (is_missed) out.push_back(pair);
  }
  return out;
}

bool is_among(const Pairs& pairs, const Pair& one) {
  return std::any_of(pairs.begin(), pairs.end(),
                     [&](const Pair& other) { return other.obstacle.id == one.obstacle.id; });
}

// The pairs at every stage; none if they were kept everywhere already.
std::optional<Ocp> widened(const Ocp& ocp, const Pairs& more) {
  std::optional<Ocp> wider;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k)
    for (const Pair& pair : more) {
      if (is_among(ocp.stages[k].pairs, pair)) continue;
      if (!wider) wider = ocp;
      wider->stages[k].pairs.push_back(pair);
    }
  return wider;
}

// The problem that holds for all that was checked, and its solution.
struct Checked {
  std::optional<Ocp> wider = {};  // with obstacles that had been left out; none: as it was
  Solution solution = {};         // iterations: of all solves
  int solves = 1;
  bool violates = false;
};

// Obstacles that were left out and turn out to matter are added, and the problem is solved again.
template <class Solver>
[[gnu::noinline]] Checked solve_checked(Solver& solver, const Recorded& recorded) {
  constexpr int kMaxSolves = 5;
  Checked out{.solution = solver(recorded.ocp, recorded.guess)};
  while (true) {
    const Ocp& ocp = out.wider ? *out.wider : recorded.ocp;
    const Pairs more = missed(ocp, out.solution.point, recorded.checked);
    out.violates = !more.empty();
    if (more.empty() || out.solves == kMaxSolves) return out;
    auto wider = widened(ocp, more);
    if (!wider) return out;
    const Solved so_far{ocp, std::move(out.solution.point), 0.0};
    const int iterations = out.solution.iterations;
    out.solution = solver(*wider, warm_start(so_far, 0.0, *wider));
    out.solution.iterations += iterations;
    out.wider = std::move(wider);
    ++out.solves;
  }
}

Pairs script_pairs(const std::vector<Obstacle>& poles) {
  Pairs pairs;
  for (const Obstacle& pole : poles) pairs.push_back({{0.0, 0.0}, 0.45, pole, 0});
  return pairs;
}

// The distances are hard constraints, so the penalty must outweigh the attraction of a goal 11 m
// away. With 500 Ipopt accepts the penalty and drives through a pole.
constexpr double kHard = 2000.0;

// Devalla's script B.2 as written: no margin, no terminal cost, the first twist tied to nothing.
// Its poles are not in it yet.
Ocp script_b2(const Pose2& X_MB, const Twist2& command) {
  Ocp ocp{.half = 0.0, .slack_weight = kHard, .X_MB = X_MB, .command = command, .workspace = 4.2};
  Stage stage;
  stage.cost.X_MR = {4, 4, 0};
  stage.cost.q_x = stage.cost.q_y = 6.0;
  stage.cost.q_theta = 4.0;
  stage.cost.r_v = 0.3;
  stage.cost.r_w = 0.15;
  for (int k = 0; k < 15; ++k) {
    const double change = k == 0 ? 2.0 : 0.1;
    ocp.v.push_back({-0.4, 0.8});
    ocp.w.push_back({-1.0, 1.0});
    ocp.change_v.push_back({-change, change});
    ocp.change_w.push_back({-change, change});
    ocp.stages.push_back(stage);
  }
  return ocp;
}

double script_cost(const Pose2& X, const Twist2& u) {
  const double e_x = X.x - 4.0, e_y = X.y - 4.0;
  return 6.0 * (e_x * e_x + e_y * e_y) + 4.0 * X.theta * X.theta + 0.3 * u.v * u.v +
         0.15 * u.w * u.w;
}

// The poles within `reach` of where the last plan is at a stage; those that it leaves out are
// checked after the solve.
template <class Solver>
Recording record_script_b2(double reach) {
  constexpr double kPeriod = 0.25;
  const Body body{.footprint = {}, .discs = {{{0.0, 0.0}, 0.45}}, .round = true};
  const PairLimits limits{.margin = 0.0, .reach = reach, .max_pairs = 16};
  const std::vector<Obstacle> poles = forest(false);
  Solver solver;
  Recording out;
  Pose2 X{-4, -4, 0};
  Twist2 command;
  std::optional<Solved> last;
  for (int i = 0; i < 120; ++i) {
    Ocp ocp = script_b2(X, command);
    const Forecast motion = last ? shifted_motion(*last, kPeriod, ocp)
                                 : Forecast{std::vector<Twist2>(15), std::vector<Pose2>(16, X)};
    auto pairs = nearest_pairs(body, poles, std::span(motion.X_MB).subspan(1), limits);
    for (std::size_t k = 0; k < pairs.size(); ++k) ocp.stages[k].pairs = std::move(pairs[k]);
    const Iterate guess = last ? warm_start(*last, kPeriod, ocp) : cold_start(ocp, motion);
    Recorded now{ocp, guess, script_pairs(poles)};
    Checked end = solve_checked(solver, now);
    if (last) out.problems.push_back(std::move(now));
    last = Solved{end.wider.value_or(ocp), std::move(end.solution.point), 0.0};
    command = {last->point.z[kV], last->point.z[kW]};
    out.closed_loop_cost += script_cost(X, command);
    X = advance(ocp, X, command);
  }
  return out;
}

// The product's problem: command in force, discs, margin that grows with speed, slack.
struct World {
  NmpcParams params = {};
  std::vector<Obstacle> obstacles = {};
  bool all_pairs = false;  // keep every disc and obstacle at every stage
  double seconds = 30.0;
};

Recording record(const World& world, const Plant& at_start, const Person& person) {
  const RobotParams robot;
  const Body body = body_of(world.params, robot);
  const double period = world.params.control_period;
  RiccatiSolver solver;
  Recording out;
  Plant plant = at_start;
  Twist2 command;
  std::optional<Solved> last;
  for (double t = 0.0; t < world.seconds; t += period) {
    PlanRequest request{.t = t, .X_MB = plant.X_MB, .command = command, .measured = plant.twist};
    request.obstacles = world.obstacles;
    person(t, plant, request);
    Cycle cycle = begin_cycle(request, world.params, robot, body);
    if (world.all_pairs) cycle.limits.reach = 1e9, cycle.limits.max_pairs = 1 << 20;
    const Forecast motion =
        last ? shifted_motion(*last, period, problem(cycle, cycle.nominal)) : cold_guess(cycle);
    Ocp ocp = problem(cycle, motion);
    const Iterate guess =
        last ? warm_start(*last, period, ocp) : cold_start(ocp, rate(cycle, ocp, motion).motion);
    if (last) out.problems.push_back({ocp, guess});
    last = Solved{ocp, solver.solve(ocp, guess, {.iterations = 300}).point, t};
    command = {last->point.z[kV], last->point.z[kW]};
    plant.run(command, period);
  }
  return out;
}

// `lag`: of the robot's motors [s], told to the planner.
Recording record_product(double lag) {
  const std::vector<Eigen::Vector2d> way{{-3, -3.4},  {-2.6, -2.9}, {0, -2.2},
                                         {2.2, -1.8}, {2.2, 0.5},   {4, 2.5}};
  World world;
  world.obstacles = forest(true);
  world.params.lag_v = world.params.lag_w = lag;
  return record(world, {{-4, -4, 0}, {}, 0.02, lag > 0.0 ? lag : 0.05},
                leader_along(way, 0.72, 1.2));
}

// Down an alley of poles on both sides; those that do not fit in two rows stand in further ones.
Recording record_alley(int horizon, int obstacles, int discs) {
  World world;
  world.all_pairs = true;
  world.seconds = 5.0;
  world.params.horizon_steps = horizon;
  const RobotParams robot;  // as wide as that many slices along it ask for
  world.params.disc_overhang =
      std::hypot(0.5 * robot.length / discs, 0.5 * robot.width) - 0.5 * robot.width;
  for (int i = 0; i < obstacles; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0, row = i / 16;
    world.obstacles.push_back({static_cast<std::uint32_t>(i + 1),
                               {0.6 + 0.5 * (i % 16 / 2), side * (0.85 + 0.7 * row)},
                               0.225,
                               0.225,
                               0.0,
                               {0, 0}});
  }
  return record(world, {{0, 0, 0}, {}}, [](double, const Plant&, PlanRequest& request) {
    request.method = Method::kGoal;
    request.X_MG = {6.0, 0.0, 0.0};
  });
}

// --- rows ----------------------------------------------------------------------------------------

double percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

// Processor time of this thread [us], independent of other load.
double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

template <class Solver>
void run(benchmark::State& state, const Recording& recording) {
  Solver solver;
  std::size_t next = 0;
  std::vector<double> times, cpu_times, iterations;
  double not_converged = 0.0, violations = 0.0, again = 0.0;
  for (auto _ : state) {
    const Recorded& now = recording.problems[next++ % recording.problems.size()];
    const double cpu_before = cpu_time();
    const auto before = Clock::now();
    const Checked checked = solve_checked(solver, now);
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - before).count());
    cpu_times.push_back(cpu_time() - cpu_before);
    const Solution& solution = checked.solution;
    iterations.push_back(solution.iterations);
    violations += checked.violates ? 1.0 : 0.0;
    again += checked.solves - 1;
    not_converged += solution.status == SolveStatus::kConverged ? 0.0 : 1.0;
  }
  if (recording.closed_loop_cost > 0.0)
    state.counters["closed_loop_cost"] = recording.closed_loop_cost;
  state.counters["p50_us"] = percentile(times, 0.5);
  state.counters["cpu_p50_us"] = percentile(cpu_times, 0.5);
  state.counters["cpu_p99_us"] = percentile(cpu_times, 0.99);
  state.counters["p99_us"] = percentile(times, 0.99);
  state.counters["iterations_p50"] = percentile(iterations, 0.5);
  state.counters["iterations_max"] = percentile(iterations, 1.0);
  state.counters["solved_again"] = benchmark::Counter(again, benchmark::Counter::kAvgIterations);
  state.counters["violations"] = benchmark::Counter(violations);
  state.counters["not_converged"] = benchmark::Counter(not_converged);
}

using Recorder = std::function<Recording()>;

// `loop`: the name under which a recording is stored.
template <class Solver>
void add_row(const std::string& row, const std::string& loop, const Recorder& recorder) {
  static std::map<std::string, Recording> recordings;
  benchmark::RegisterBenchmark(row.c_str(), [=](benchmark::State& state) {
    if (!recordings.contains(loop)) recordings[loop] = recorder();
    run<Solver>(state, recordings[loop]);
  })->Unit(benchmark::kMicrosecond);
}

void add_rows(const std::string& problem, const Recorder& recorder) {
  add_row<Structured>("structured/" + problem, problem, recorder);
  add_row<Certified>("certified/" + problem, problem, recorder);
  add_row<Ipopt>("ipopt/" + problem, problem, recorder);
}

template <class Solver>
void add_script(const std::string& solver) {
  const auto add = [&](const std::string& poles, double reach) {
    const std::string row = solver + "/script_b2/" + poles;
    add_row<Solver>(row, row, [=] { return record_script_b2<Solver>(reach); });
  };
  add("poles:all", 1e9);
  add("poles:near", PairLimits{}.reach);
}

void add_all() {
  add_script<Structured>("structured");
  add_script<Certified>("certified");
  add_script<Ipopt>("ipopt");
  add_script<IpoptWithMumps>("ipopt_with_mumps");
  add_rows("product", [] { return record_product(0.0); });
  add_rows("product/lag", [] { return record_product(0.4); });
  const auto alley = [](int horizon, int obstacles, int discs) {
    add_rows("alley/N:" + std::to_string(horizon) + "/obstacles:" + std::to_string(obstacles) +
                 "/discs:" + std::to_string(discs),
             [=] { return record_alley(horizon, obstacles, discs); });
  };
  for (const int horizon : {10, 20, 30, 40, 60}) alley(horizon, 8, 3);
  for (const int obstacles : {0, 2, 4, 16, 32, 64}) alley(15, obstacles, 3);
  for (const int discs : {1, 2, 3, 4}) alley(15, 8, discs);
  alley(60, 32, 3);
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  tandem::test::add_all();
  benchmark::RunSpecifiedBenchmarks();
}
