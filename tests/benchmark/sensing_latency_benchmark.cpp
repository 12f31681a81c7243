// SPDX-License-Identifier: Apache-2.0
// Measures the latency from /scan to the inputs of filter and planner over DDS, with each component
// as a separate node. Prints quantiles.
#include <algorithm>
#include <cstdio>
#include <numbers>
#include <optional>
#include <vector>

#include "bringup/system/system.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {
namespace {

constexpr int kThings = 30;
constexpr int kBeams = 720;
constexpr float kRoom = 5.0F, kThing = 1.2F;  // [m] radius of the room, distance of the thing
constexpr double kTimeout = 3.0;              // [s]

// A robot at rest in a round room; an object in front of it appears and disappears.
class Scanner {
 public:
  explicit Scanner(rt::Node& node) : node_{node} {
    status_ = node.create_subscription(topics::filter_status, [this](const auto& msg) {
      if (from_msg(msg.reason_code()) == Reason::kClear) filter_knows_ = msg.clearance() < 0.9;
    });
    list_ = node.create_subscription(topics::obstacles, [this](const auto& msg) {
      const auto all = from_msg(msg).all;
      planner_knows_ = std::any_of(all.begin(), all.end(),
                                   [](const Obstacle& o) { return o.p_MO.norm() < 1.6; });
      ++lists_;
    });
    beat_ = node.create_wall_timer(0.02, [this] {
      odom_.publish(to_msg(Odometry{}, header(node_.stamp(), "odom"), "base_link"));
      command_.publish(to_msg(Twist2{}));
    });
    scans_ = node.create_wall_timer(0.1, [this] { scan(); });
  }

  [[nodiscard]] bool is_ready() {
    return test::spin_until([this] { return lists_ > 0; }, 30.0, node_);
  }
  // Milliseconds from the first scan that shows the object to filter and planner.
  void show(std::vector<double>& filter, std::vector<double>& planner) {
    shows_ = true;
    shown_at_.reset();
    (void)test::spin_until([this] { return shown_at_.has_value(); }, kTimeout, node_);
    const double t = *shown_at_;
    double to_filter = kTimeout;
    (void)test::spin_until(
        [&] {
          if (filter_knows_) to_filter = std::min(to_filter, node_.steady_now() - t);
          return filter_knows_ && planner_knows_;
        },
        kTimeout, node_);
    filter.push_back(1e3 * to_filter);
    planner.push_back(1e3 * (node_.steady_now() - t));
    shows_ = false;
    (void)test::spin_until([&] { return !filter_knows_ && !planner_knows_; }, kTimeout, node_);
  }

 private:
  void scan() {
    sensor_msgs::msg::LaserScan msg;
    msg.header(header(node_.stamp(), "base_scan"));
    msg.angle_increment(static_cast<float>(2.0 * std::numbers::pi / kBeams));
    msg.range_max(10.0F);
    msg.ranges().assign(kBeams, kRoom);
    if (shows_) std::fill_n(msg.ranges().begin(), kBeams / 24, kThing);
    scan_.publish(msg);
    if (shows_ && !shown_at_) shown_at_ = node_.steady_now();
  }

  rt::Node& node_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ = node_.create_publisher(topics::scan);
  rt::Subscription status_, list_;
  rt::Timer beat_, scans_;
  std::optional<double> shown_at_;
  bool shows_ = false, filter_knows_ = false, planner_knows_ = false;
  long lists_ = 0;
};

void print(const char* to, const std::vector<double>& ms) {
  const Quantiles q = quantiles(ms);
  std::printf("/scan -> %-16s p50 %6.1f  p95 %6.1f  p99 %6.1f  max %6.1f ms\n", to, q.p50, q.p95,
              q.p99, q.max);
}

int measure() {
  System system;
  for (const char* component : {"octomap_builder", "obstacle_extractor", "safety_filter"}) {
    rt::NodeOptions options;
    options.name = component;
    options.parameters.values["map_is_odom"] = {"true", "benchmark"};
    if (std::string(component) == "octomap_builder")
      options.parameters.values["scan_pose"] = {"[0, 0, 0.3, 0, 0, 0]", "benchmark"};
    else
      options.parameters.values["map_source"] = {"local", "benchmark"};
    system.nodes.push_back({component, std::move(options)});
  }
  RunningSystem running{system};
  rt::Node node{"scanner"};
  Scanner scanner{node};
  if (!scanner.is_ready()) return 1;
  std::vector<double> filter, planner;
  for (int n = 0; n < kThings; ++n) scanner.show(filter, planner);
  running.stop();
  running.wait();
  print("safety filter", filter);
  print("/obstacles", planner);
  return 0;
}

}  // namespace
}  // namespace tandem

int main() { return tandem::measure(); }
