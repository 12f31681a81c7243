// SPDX-License-Identifier: Apache-2.0
// Tests `tandem teleop` in a simulated terminal, next to a running system.
#include <pty.h>

#include "support/paths.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

constexpr double kLong = 60.0;  // [s] for a slow machine under a sanitizer

// A program in a separate terminal.
class InTerminal {
 public:
  InTerminal() {
    const std::string program = binary_path("tandem");
    pid_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
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
    const auto size = read(terminal_, text, sizeof text);
    return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
  }

 private:
  int terminal_ = -1;
  pid_t pid_;
};

TEST(TeleopCommand, DrivesWhileAKeyRepeatsAndShowsWhatTheRobotDoes) {
  SystemUnderTest system{source_path("bringup/systems/teleop.yaml")};
  // A robot whose joystick has its stick and its button elsewhere.
  const std::vector<std::string> joystick{"-p", "teleop:axis_linear:=4", "-p",
                                          "teleop:deadman_button:=5"};
  std::vector<std::string> run{"run", source_path("bringup/systems/teleop.yaml"), "--ros-args"};
  run.insert(run.end(), joystick.begin(), joystick.end());
  ChildProcess robot{"../tandem", run};
  const InTerminal keyboard;
  double typed = 0.0;
  const auto hold = [&] {
    if (rt::steady_seconds() - typed > 0.03) keyboard.type("i");
    if (rt::steady_seconds() - typed > 0.03) typed = rt::steady_seconds();
    return system.truth.twist.v > 0.3;
  };
  ASSERT_TRUE(system.wait_until(hold, kLong));
  ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, kLong));
  std::string screen;
  for (const double end = rt::steady_seconds() + kLong;
       screen.find("shared, ") == std::string::npos && rt::steady_seconds() < end;)
    screen += keyboard.read_screen();
  EXPECT_NE(screen.find("clearance"), std::string::npos);
  EXPECT_NE(screen.find("shared, "), std::string::npos) << screen;
  keyboard.type(" ");
  EXPECT_TRUE(system.wait_until([&] { return system.reason == Reason::kEmergencyStop; }, kLong));
}

}  // namespace
}  // namespace tandem::test
