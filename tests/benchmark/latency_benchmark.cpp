// SPDX-License-Identifier: Apache-2.0
// From /joy to /cmd_vel over DDS, every component its own node: how long until a push of the stick
// reaches the wheels. Prints quantiles for policy manual and policy shared, the latter by method
// intention: a leader has to get away from the robot before the robot follows.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bringup/system.hpp"
#include "metrics/metrics.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

constexpr int kPushes = 150;
constexpr double kRate = 20.0;   // [Hz] of the joystick
constexpr double kMoves = 0.01;  // [m/s, rad/s] a command that is no rest

class Stick {
 public:
  explicit Stick(rt::Node& node) : node_{node}, joy_{node.create_publisher(topics::joy)} {
    cmd_vel_ = node.create_subscription(topics::cmd_vel, [this](const auto& msg) {
      moves_ = std::abs(msg.linear().x()) > kMoves || std::abs(msg.angular().z()) > kMoves;
    });
    repeat_ = node.create_wall_timer(1.0 / kRate, [this] { send(); });
  }

  // Seconds from a push to the first command that moves, turning one way and then the other.
  double push(int n) {
    angular_ = n % 2 == 0 ? 0.6 : -0.6;
    const double pushed = node_.steady_now();
    send();
    if (!test::spin_until([this] { return moves_; }, 5.0, node_)) return 5.0;
    return node_.steady_now() - pushed;
  }
  void rest() {
    angular_ = 0.0;
    (void)test::spin_until([this] { return !moves_; }, 5.0, node_);
    const double until = node_.steady_now() + 0.3 + 0.013 * (++rests_ % 7);  // not in step
    (void)test::spin_until([&] { return node_.steady_now() > until; }, 5.0, node_);
  }
  [[nodiscard]] bool connected() { return joy_.matched() > 0 && cmd_vel_.matched() > 0; }

 private:
  void send() {
    sensor_msgs::msg::Joy msg;
    msg.axes({static_cast<float>(angular_), 0.0f});
    msg.buttons({1, 0});
    joy_.publish(msg);
  }

  rt::Node& node_;
  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  rt::Subscription cmd_vel_;
  rt::Timer repeat_;
  double angular_ = 0.0;
  bool moves_ = false;
  int rests_ = 0;
};

void measure(const char* policy) {
  System system = load_system(test::source_path("bringup/systems/teleop.yaml"));
  for (SystemNode& node : system.nodes) {
    auto& values = node.options.parameters.values;
    if (node.component == "arbitration") values["policy"] = {policy, "latency_benchmark"};
    if (node.component == "local_planner") values["method"] = {"intention", "latency_benchmark"};
  }
  RunningSystem running{system};
  rt::Node node{"stick"};
  Stick stick{node};
  if (!test::spin_until([&] { return stick.connected(); }, 20.0, node)) return;
  std::vector<double> ms;
  for (int n = 0; n < kPushes; ++n) {
    stick.rest();
    const double latency = 1e3 * stick.push(n);
    if (n >= 10) ms.push_back(latency);
  }
  running.stop();
  running.wait();
  const Quantiles q = quantiles(ms);
  std::printf("/joy -> /cmd_vel, policy %-7s p50 %6.1f  p95 %6.1f  p99 %6.1f  max %6.1f ms\n",
              policy, q.p50, q.p95, q.p99, q.max);
}

}  // namespace
}  // namespace tandem

int main() {
  setenv("TANDEM_COMPONENT_PATH", tandem::test::binary_path().c_str(), 0);
  tandem::measure("manual");
  tandem::measure("shared");
}
