// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/teleop_command.hpp"

#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "bringup/cli/terminal_keys.hpp"
#include "bringup/cli/terminal_line.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {
namespace {

constexpr double kBeat = 0.04;     // [s] between two joy messages
constexpr double kShow = 0.2;      // [s] between updates of the status line
constexpr double kFresh = 0.5;     // [s] older status counts as missing
constexpr int kReleases = 3;       // joy messages sent after a release, because one may be lost
constexpr double kPatience = 1.0;  // [s] timeout for teleop's answer
constexpr double kPress = 2.0;     // [s] a key held for longer is not a new press

const std::vector<std::string> kLayout{"axis_linear",  "axis_angular",  "deadman_button",
                                       "scale_linear", "scale_angular", "axis_range"};

// Reads characters without echo, line buffering or blocking. Ctrl-C still raises SIGINT.
class RawTerminal {
 public:
  RawTerminal() {
    if (tcgetattr(STDIN_FILENO, &before_) != 0)
      throw std::runtime_error("teleop reads keys: standard input must be a terminal");
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = raw.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  ~RawTerminal() { tcsetattr(STDIN_FILENO, TCSANOW, &before_); }
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  [[nodiscard]] static std::size_t width() {
    winsize size{};
    const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return known ? size.ws_col : 80;
  }
  // The characters typed since the last call.
  [[nodiscard]] static std::string read_keys() {
    char keys[256];
    const auto size = read(STDIN_FILENO, keys, sizeof keys);
    return {keys, size > 0 ? static_cast<std::size_t>(size) : 0};
  }

 private:
  termios before_{};
};

double no_minus(double value) { return std::abs(value) < 0.005 ? 0.0 : value; }

class KeyboardTeleop {
 public:
  explicit KeyboardTeleop(rt::Node& node)
      : node_{node},
        joy_{node.create_publisher(topics::joy)},
        e_stop_{node.create_publisher(topics::e_stop)},
        release_{node.create_client(
            rt::ServiceName<std_srvs::srv::Trigger>{"arbitration/release_emergency_stop"})},
        ask_layout_{node.create_client(
            rt::ServiceName<rcl_interfaces::srv::GetParameters>{"teleop/get_parameters"})} {
    ask_layout();
    odom_ = node.create_subscription(topics::odom, [this](const auto& msg) {
      if (const auto odometry = from_msg(msg)) speed_ = {odometry->twist, node_.steady_now()};
    });
    on_filter_ = node.create_subscription(topics::filter_status, [this](const auto& msg) {
      filter_ = {clearance_text(msg.clearance()) + ", " + msg.reason(), node_.steady_now()};
    });
    arbitration_ = node.create_subscription(topics::arbitration_status, [this](const auto& msg) {
      mode_ = {msg.policy() + ", " + msg.reason(), node_.steady_now()};
      refused_ = from_msg(msg.reason_code()) == Reason::kStickMoved;
    });
    teleop_ = node.create_subscription(topics::teleop_status, [this](const auto& msg) {
      trouble_ = {msg.data(), node_.steady_now()};
    });
    beat_ = node.create_wall_timer(kBeat, [this] { beat(); });
    show_ = node.create_wall_timer(kShow, [this] { show(); });
  }

 private:
  void beat() {
    const double now = node_.steady_now();
    const auto order = keys_.type(RawTerminal::read_keys(), now);
    if (order == TerminalKeys::Order::kEmergencyStop) press_stop(true);
    if (order == TerminalKeys::Order::kRelease) press_stop(false);
    const auto stick = keys_.held(now);
    if (stick) releases_ = kReleases;
    if (!stick && releases_-- <= 0) return;
    if (!layout_) return;
    // A key sets dead-man and axes at once, but teleop requires the stick at rest when the dead-man
    // is pressed. The first sample of a press therefore has zero axes. It may be lost, so zeros are
    // also sent while teleop or arbitration reports that it has not seen the stick at rest.
    if (!sent_held_) pressed_ = now;
    const bool must_rest = now - pressed_ <= kPress && is_refused(now);
    const bool goes_on = std::exchange(sent_held_, stick.has_value()) && !must_rest;
    const auto keys = goes_on ? stick.value_or(TerminalKeys::Stick{}) : TerminalKeys::Stick{};
    const auto joy = joy_values(
        {.linear = keys.linear, .angular = keys.angular, .deadman = stick.has_value()}, *layout_);
    sensor_msgs::msg::Joy msg;
    msg.header(header(node_.stamp(), "keyboard"));
    msg.axes(joy.axes);
    msg.buttons(joy.buttons);
    joy_.publish(msg);
  }

  [[nodiscard]] bool is_refused(double now) const {
    return (mode_.fresh(now, kFresh) && refused_) ||
           (trouble_.fresh(now, kFresh) && trouble_.value == kNotAtRest);
  }

  // Asks teleop which axes and button it reads. If it does not answer (not started yet, or another
  // implementation), uses the defaults and asks again.
  void ask_layout() {
    rcl_interfaces::srv::GetParameters::Request request;
    request.names(kLayout);
    ask_layout_.call(
        request, [this](const auto& answer) { read_layout(answer.values()); }, kPatience,
        [this] {
          if (!layout_) layout_.emplace();
          ask_layout();
        });
  }

  void read_layout(const std::vector<rcl_interfaces::msg::ParameterValue>& values) {
    layout_.emplace();
    if (values.size() != kLayout.size()) return;
    layout_->axis_linear = static_cast<int>(values[0].integer_value());
    layout_->axis_angular = static_cast<int>(values[1].integer_value());
    layout_->deadman_button = static_cast<int>(values[2].integer_value());
    layout_->gains.scale_linear = values[3].double_value();
    layout_->gains.scale_angular = values[4].double_value();
    if (values[5].double_value() > 0.0) layout_->axis_range = values[5].double_value();
  }

  void press_stop(bool pressed) {
    std_msgs::msg::Bool msg;
    msg.data(pressed);
    e_stop_.publish(msg);
    if (!pressed) release_.call({}, [this](const auto& answer) { said_ = answer.message(); });
    said_ = pressed ? "emergency stop" : "";
  }

  void show() const {
    const double now = node_.steady_now();
    const auto fresh = [now](const auto& value) { return value.fresh(now, kFresh); };
    std::string line = said_.empty() ? "" : said_ + " | ";
    line += fresh(speed_) ? fmt::format("{:.2f} m/s {:.2f} rad/s", no_minus(speed_.value.v),
                                        no_minus(speed_.value.w))
                          : "no odometry";
    line += " | " + (fresh(mode_) ? mode_.value : "arbitration is silent");
    if (fresh(trouble_) && !trouble_.value.empty()) line += " | " + trouble_.value;
    line += " | " + (fresh(filter_) ? filter_.value : "the filter is silent");
    line += fmt::format(" | keys {:.0f}/{:.0f} %", 100.0 * keys_.linear_scale(),
                        100.0 * keys_.angular_scale());
    std::printf("\r\x1b[K%s", one_line(line, RawTerminal::width()).c_str());
    std::fflush(stdout);
  }

  rt::Node& node_;
  TerminalKeys keys_;
  int releases_ = 0;
  bool sent_held_ = false;  // the dead-man was pressed in the last joy message
  double pressed_ = 0.0;    // [s] start of the current press
  bool refused_ = false;    // arbitration reports that it has not seen the stick at rest
  std::optional<TeleopParams> layout_;
  Stamped<Twist2> speed_;
  Stamped<std::string> mode_, filter_, trouble_;
  std::string said_;
  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  rt::Publisher<std_msgs::msg::Bool> e_stop_;
  rt::Client<std_srvs::srv::Trigger> release_;
  rt::Client<rcl_interfaces::srv::GetParameters> ask_layout_;
  rt::Subscription odom_, on_filter_, arbitration_, teleop_;
  rt::Timer beat_, show_;
};

void teleop() {
  const RawTerminal terminal;
  rt::install_signal_handlers();
  rt::Node node{"tandem_teleop"};
  const KeyboardTeleop keyboard{node};
  std::puts(
      "Hold to drive:   u i o      q/z all, w/x forward, e/c turning: faster, slower\n"
      "                 j   l      space: emergency stop, r: release it\n"
      "                 m , .      any other key stops; Ctrl-C ends. The arrows drive, too.");
  node.spin();
  std::puts("");
}

}  // namespace

void add_teleop_command(CLI::App& app) {
  auto* command = app.add_subcommand("teleop", "Drive with the keys of this terminal");
  command->callback([] { teleop(); });
}

}  // namespace tandem
