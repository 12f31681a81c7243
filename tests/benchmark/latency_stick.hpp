// SPDX-License-Identifier: Apache-2.0
// Pushes a stick repeatedly and measures the time until the wheels are commanded.
#pragma once

#include <cmath>
#include <vector>

#include "support/spin_until.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

inline constexpr double kRate = 20.0;   // [Hz] of the joystick
inline constexpr double kMoves = 0.01;  // [m/s, rad/s] a command that is no rest

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

/// Quantiles [ms] of `pushes`, without the first ten.
inline Quantiles latency_of(Stick& stick, int pushes) {
  std::vector<double> ms;
  for (int n = 0; n < pushes; ++n) {
    stick.rest();
    const double latency = 1e3 * stick.push(n);
    if (n >= 10) ms.push_back(latency);
  }
  return quantiles(ms);
}

}  // namespace tandem
