// SPDX-License-Identifier: Apache-2.0
// Tests `tandem teleop` in a simulated terminal, next to a running system.
#include <pty.h>

#include <cerrno>
#include <cmath>
#include <system_error>

#include "support/paths.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

// A program in a separate terminal.
class InTerminal {
 public:
  InTerminal() {
    const std::string program = binary_path("tandem");
    pid_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "no terminal");
    if (pid_ != 0) return;
    execl(program.c_str(), "tandem", "teleop", nullptr);
    _exit(127);
  }
  ~InTerminal() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    close(terminal_);
  }
  InTerminal(const InTerminal&) = delete;
  InTerminal& operator=(const InTerminal&) = delete;

  void type(const std::string& keys) const {
    EXPECT_EQ(write(terminal_, keys.data(), keys.size()), std::ssize(keys));
  }
  /// What the program has shown, one reading of it.
  [[nodiscard]] std::string read_screen() const {
    char text[4096];
    const auto size = ::read(terminal_, text, sizeof text);
    return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
  }

 private:
  int terminal_ = -1;
  pid_t pid_;
};

// Holds the key for forward until the robot drives. A robot that was discovered only after the
// first seconds of a press asks for another press, so the key is let go for a second in every five.
bool drive(SystemUnderTest& system, const InTerminal& keyboard) {
  const double start = rt::steady_seconds();
  double typed = 0.0;
  const auto hold = [&] {
    const bool is_let_go = std::fmod(rt::steady_seconds() - start, 5.0) > 4.0;
    if (!is_let_go && rt::steady_seconds() - typed > 0.03) {
      keyboard.type("i");
      typed = rt::steady_seconds();
    }
    return system.truth.twist.v > 0.3;
  };
  return system.wait_until(hold, kLongTimeout);
}

TEST(TeleopCommand, DrivesWhileAKeyRepeatsAndShowsWhatTheRobotDoes) {
  SystemUnderTest system{source_path("bringup/systems/teleop.yaml")};
  // A robot whose joystick has its stick and its button elsewhere.
  const std::vector<std::string> joystick{"-p", "teleop:axis_linear:=4", "-p",
                                          "teleop:deadman_button:=5"};
  std::vector<std::string> run{"run", source_path("bringup/systems/teleop.yaml"), "--ros-args"};
  run.insert(run.end(), joystick.begin(), joystick.end());
  ChildProcess robot{"../tandem", run};
  const InTerminal keyboard;
  ASSERT_TRUE(drive(system, keyboard));
  ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, kLongTimeout));
  std::string screen;
  for (const double end = rt::steady_seconds() + kLongTimeout;
       screen.find("shared, ") == std::string::npos && rt::steady_seconds() < end;)
    screen += keyboard.read_screen();
  EXPECT_NE(screen.find("clearance"), std::string::npos);
  EXPECT_NE(screen.find("shared, "), std::string::npos) << screen;
  keyboard.type(" ");
  EXPECT_TRUE(
      system.wait_until([&] { return system.reason == Reason::kEmergencyStop; }, kLongTimeout));
}

// Without arbitration only teleop tells that it has missed the first sample, which is sent at rest.
TEST(TeleopCommand, DrivesWithoutArbitrationAtEveryStart) {
  SystemUnderTest system{source_path("bringup/systems/teleop.yaml")};
  system.start("teleop", {"--ros-args", "-r", "cmd_vel_user:=cmd_vel"});
  system.start("diff_drive_sim");
  for (int start = 0; start < 5; ++start) {
    {
      const InTerminal keyboard;
      ASSERT_TRUE(drive(system, keyboard)) << "start " << start;
    }
    ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, kLongTimeout));
  }
}

}  // namespace
}  // namespace tandem::test
