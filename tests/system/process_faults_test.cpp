// SPDX-License-Identifier: Apache-2.0
// Like faults_test.cpp, for faults of processes and their clocks.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <tuple>

#include "support/paths.hpp"
#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

TEST_F(Faults, OfProcesses) {
  const std::tuple<const char*, const char*, Told> victims[] = {
      {"map_server", nullptr, Told::kOnBoth},
      {"driver", "cmd_vel_user is silent", Told::kOnBoth},
      {"teleop", "cmd_vel_user is silent", Told::kOnBoth},
      {"obstacle_extractor", "planner: obstacles are silent", Told::kOnBoth},
      {"local_planner", "cmd_vel_shared is silent", Told::kOnBoth},
      // Before arbitration: only one that has heard the filter reports its silence, and the
      // commands of one that was just started may pass before that.
      {"safety_filter", "safety filter is silent", Told::kOnBoth},
      {"arbitration", "no command", Told::kOnDiagnostics}};
  std::vector<Fault> faults;
  for (const auto& [victim, reason, told] : victims) {
    const std::string name = victim;
    faults.push_back({name + " stopped, then continued",
                      [this, name] { system_.process(name).send(SIGSTOP); },
                      [this, name] { system_.process(name).send(SIGCONT); }, reason, told});
    faults.push_back({name + " killed, then started again",
                      // Not waited for: the relays are ours and must go on meanwhile.
                      [this, name] { system_.process(name).send(SIGKILL); },
                      [this, name] { system_.start_relayed(name); }, reason, told});
  }
  suffer(faults);
}

// Odometry, ground truth and time are lost with it: the test can only require a zero command and
// the reason.
class SimulatorFaults : public Faults {
 protected:
  void stand_and_say(const char* what, int signal) {
    ASSERT_TRUE(system_.wait_until_driving());
    system_.forget();
    const double began = rt::steady_seconds();
    simulator().send(signal);
    EXPECT_TRUE(system_.wait_until([&] { return system_.command == Twist2{}; }, 5.0));
    const double took = rt::steady_seconds() - began;
    EXPECT_LE(took, kNoClock + kZeroWithin / kSpeed);
    EXPECT_TRUE(
        system_.wait_until([&] { return system_.said("/clock is silent", Told::kOnBoth); }, 5.0))
        << system_.sayings();
    rows_.push_back({std::string{"simulator "} + what + " (to a command of zero)",
                     1,
                     system_.collisions,
                     {took}});
    system_.truth = {};  // nobody knows
    system_.sim_time = kNever;
  }
  [[nodiscard]] ChildProcess& simulator() { return system_.process("diff_drive_sim"); }

  std::vector<Row> rows_;

  static constexpr double kNever = -1.0;
  static constexpr double kOld = 4.0;  // [s] more than it takes to find the new one
};

TEST_F(SimulatorFaults, StandsWhileItIsAwayAndDrivesOnInTheTimeThatItBrings) {
  stand_and_say("stopped", SIGSTOP);
  simulator().send(SIGCONT);
  EXPECT_TRUE(system_.wait_until_driving()) << "does not drive on";
  ASSERT_TRUE(system_.wait_until([&] { return system_.sim_time > kOld; }, 2.0 * kOld));
  EXPECT_EQ(system_.collisions, 0U);
  stand_and_say("killed", SIGKILL);
  system_.process("driver").send(SIGSTOP);
  // The new simulation's time starts at zero. Data from the old one must not count as new.
  system_.start_relayed("diff_drive_sim");
  ASSERT_TRUE(system_.wait_until([&] { return system_.sim_time != kNever; }, 10.0));
  EXPECT_LT(system_.sim_time, kOld);
  bool moves = false;
  EXPECT_TRUE(system_.wait_until(
      [&] {
        moves = !system_.stands() || !(system_.command == Twist2{});
        return moves || system_.sim_time > kOld + 1.0;
      },
      20.0));
  EXPECT_FALSE(moves) << "an old command came back at " << system_.sim_time
                      << " s: " << system_.command.v << " m/s, " << system_.command.w
                      << " rad/s; moves at " << system_.truth.twist.v << "; " << system_.sayings();
  system_.process("driver").send(SIGCONT);
  EXPECT_TRUE(system_.wait_until_driving()) << "does not drive on";
  EXPECT_EQ(system_.collisions, 0U);
  print(rows_);
}

// Commands that were in transit when a process was suspended are not executed when it resumes.
TEST_F(Faults, NoOldCommandComesBack) {
  ASSERT_TRUE(system_.wait_until_driving());
  system_.process("safety_filter").send(SIGSTOP);
  ASSERT_TRUE(system_.wait_until([&] { return system_.stands(); }, 5.0));
  system_.process("driver").send(SIGSTOP);  // nobody wants to drive any more
  ASSERT_TRUE(system_.wait_until([&] { return !system_.deadman; }, 5.0));
  // The last command that was meant may still be carried out for its lifespan; none is meanwhile.
  const double silent = system_.sim_time;
  ASSERT_TRUE(system_.wait_until([&] { return system_.sim_time > silent + 1.0; }, 10.0));
  ASSERT_FALSE(system_.deadman);
  const double continued = system_.sim_time;
  const long commands = system_.commands;
  bool moved = false;
  system_.process("safety_filter").send(SIGCONT);
  EXPECT_TRUE(system_.wait_until(
      [&] {
        moved = moved || !system_.stands() ||
                (system_.commands > commands && !(system_.command == Twist2{}));
        return system_.sim_time > continued + 1.0;
      },
      10.0));
  EXPECT_FALSE(moved) << "command " << system_.command.v << " m/s, " << system_.command.w
                      << " rad/s; moves at " << system_.truth.twist.v;
  EXPECT_GT(system_.commands, commands);  // it is back
}

class ClockFaults : public Faults {
 protected:
  ClockFaults() : Faults{true} {}
  ~ClockFaults() override { std::filesystem::remove(offset_); }

  // What is started meanwhile has a system clock that can be set, see system_clock_offset.c.
  void with_own_clock(const std::function<void()>& start) const {
    setenv("TANDEM_CLOCK_OFFSET", offset_.c_str(), 1);
    setenv("LD_PRELOAD", binary_path("tests/libsystem_clock_offset.so").c_str(), 1);
    start();
    unsetenv("LD_PRELOAD");
  }
  void restart_with_own_clock(const std::string& name) {
    set_clock(0);
    system_.process(name).send(SIGKILL);
    with_own_clock([&] { system_.start_relayed(name); });
  }
  [[nodiscard]] double own_clock() const {
    FILE* date = nullptr;
    with_own_clock([&] { date = popen("date +%s", "r"); });
    double seconds = 0.0;
    EXPECT_EQ(std::fscanf(date, "%lf", &seconds), 1);
    pclose(date);
    return seconds;
  }
  void set_clock(double offset) const {  // [s]
    const std::int64_t nanoseconds = std::llround(1e9 * offset);
    const int file = open(offset_.c_str(), O_WRONLY | O_CREAT, 0600);  // others have it mapped
    EXPECT_EQ(pwrite(file, &nanoseconds, sizeof nanoseconds, 0),
              static_cast<ssize_t>(sizeof nanoseconds));
    close(file);
  }

 private:
  std::filesystem::path offset_ =
      std::filesystem::temp_directory_path() / ("tandem_clock_" + std::to_string(getpid()));
};

// Set and left so: the robot drives on with clocks that differ.
TEST_F(ClockFaults, OfSystemClocks) {
  set_clock(1000.0);
  EXPECT_NEAR(own_clock() - 1e-9 * static_cast<double>(rt::system_nanoseconds()), 1000.0, 3.0);
  for (const char* name : {"teleop", "safety_filter"}) {
    restart_with_own_clock(name);
    const auto set = [this](double offset) { return [this, offset] { set_clock(offset); }; };
    const std::string clock = std::string{"system clock of "} + name;
    suffer({{clock + " set 10 s forward", set(10.0), [] {}},
            {clock + " set back by 30 s", set(-20.0), [] {}}});
  }
}

TEST_F(ClockFaults, OfSimulatedTime) {
  const auto stepped = [this](double by) {
    return [this, by] {
      system_.clock->spoil([by](rosgraph_msgs::msg::Clock& m) {
        m.clock().sec(m.clock().sec() + static_cast<int>(by));
      });
    };
  };
  const auto right = [this] { system_.clock->pass(); };
  Fault lost{"/clock lost", [this] { system_.clock->drop(); }, right, "/clock is silent"};
  lost.zero_within = kNoClock * kSpeed + kZeroWithin;
  const char* all_is_old = "safety filter: not localized";
  suffer({{"/clock 5 s ahead, and back again", stepped(5), right, all_is_old},
          {"/clock 5 s behind, and on again", stepped(-5), right},
          lost});
}

}  // namespace
}  // namespace tandem::test
