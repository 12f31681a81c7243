// SPDX-License-Identifier: Apache-2.0
// Runs the forest system with a relay in each link, and defines the faults and their expected
// effects.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>

#include "system/relay.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {

inline constexpr double kNoTransform = 1.0;  // [s] without map → odom until a zero command
inline constexpr double kNoClock = 0.5;      // [s] real time without /clock until a zero command
// [s] duration of a fault that need not stop the robot
inline constexpr double kLasts = 2.0 * kSpeed;

/// Where the reason is reported.
enum class Told {
  kOnBoth,         ///< /arbitration/status and /diagnostics
  kOnDiagnostics,  ///< /diagnostics only: arbitration is gone
  kNowhere,        ///< the base stops on its own timeout; no component knows what the base receives
};

/// A fault and its expected effect.
struct Fault {
  std::string name;
  std::function<void()> begin, end;
  const char* reason = nullptr;  ///< null: it may drive on, unless told is kNowhere
  Told told = Told::kOnBoth;
  double zero_within = kZeroWithin;
  double lasts = 0.0;            ///< [s] minimum duration
  std::function<bool()> done{};  ///< the fault also lasts until this holds

  [[nodiscard]] bool stands() const { return reason != nullptr || told == Told::kNowhere; }
};

struct Row {
  std::string name;
  int tries = 0;
  unsigned collisions = 0;
  std::vector<double> to_stand;  // [s] simulated
};

/// The forest system and the reasons that it reports.
class WatchedSystem : public SystemUnderTest {
 public:
  WatchedSystem() {
    status_ = node().create_subscription(
        topics::arbitration_status, [this](const auto& msg) { status_said_.insert(msg.reason()); });
    diagnostics_ = node().create_subscription(topics::diagnostics, [this](const auto& msg) {
      for (const auto& status : msg.status()) diagnosed_.insert(status.message());
    });
  }

  [[nodiscard]] bool said(const char* why, Told where) const {
    return why == nullptr ||
           (diagnosed_.contains(why) && (where != Told::kOnBoth || status_said_.contains(why)));
  }
  /// True if any node reported that reason.
  [[nodiscard]] bool heard_any(const char* why) const {
    return diagnosed_.contains(why) || status_said_.contains(why);
  }
  void forget() {
    status_said_.clear();
    diagnosed_.clear();
  }
  /// Reports since the last forget(), for failure messages.
  [[nodiscard]] std::string sayings() const {
    std::string text = "status:";
    for (const auto& said : status_said_) text += " `" + said + "`";
    text += "; diagnostics:";
    for (const auto& said : diagnosed_) text += " `" + said + "`";
    return text;
  }

 private:
  std::set<std::string> status_said_, diagnosed_;
  rt::Subscription status_, diagnostics_;
};

/// The forest system with a relay in each link, in that of /clock only if requested.
class RelayedSystem : public WatchedSystem {
 public:
  explicit RelayedSystem(bool relays_clock = false) {
    if (relays_clock) clock.emplace(node(), topics::clock);
    sent_ = node().create_subscription(
        rt::Topic<geometry_msgs::msg::Twist>{"cmd_vel_raw", topics::cmd_vel.qos},
        [this](const auto& msg) { unsound += from_msg(msg) ? 0 : 1; });
    for (const char* name : kComponents) start_relayed(name);
  }

  void start_relayed(const std::string& name) { start(name, remappings(name)); }

  int unsound = 0;  ///< non-finite commands of the filter

  Relay<sensor_msgs::msg::Joy> joy{node(), topics::joy};
  Relay<geometry_msgs::msg::Twist> user{node(), topics::cmd_vel_user};
  Relay<geometry_msgs::msg::PoseStamped> leader{node(), topics::leader_pose};
  Relay<tandem_msgs::msg::ObstacleArray> obstacles{node(), topics::obstacles};
  Relay<geometry_msgs::msg::Twist> shared{node(), topics::cmd_vel_shared};
  Relay<geometry_msgs::msg::Twist> arbitrated{node(), topics::cmd_vel_arbitrated};
  Relay<geometry_msgs::msg::Twist> cmd_vel{node(), topics::cmd_vel};
  Relay<nav_msgs::msg::Odometry> odom{node(), topics::odom};
  Relay<tf2_msgs::msg::TFMessage> tf{node(), topics::tf};
  Relay<octomap_msgs::msg::Octomap> map{node(), topics::octomap_binary};
  std::optional<Relay<rosgraph_msgs::msg::Clock>> clock;

 private:
  [[nodiscard]] std::vector<std::string> remappings(const std::string& name) const {
    if (name == "driver") return joy.remapping();
    if (name == "obstacle_extractor") return obstacles.remapping();
    if (name == "local_planner") return shared.remapping();
    if (name == "arbitration") return arbitrated.remapping();
    if (name == "safety_filter") return cmd_vel.remapping();
    if (name == "map_server") return map.remapping();
    if (name == "diff_drive_sim") {
      const auto moving = both(odom.remapping(), tf.remapping());
      return clock ? both(moving, clock->remapping()) : moving;
    }
    if (name == "teleop") return both(user.remapping(), leader.remapping());
    return {};
  }
  // Drops the second list's --ros-args.
  static std::vector<std::string> both(std::vector<std::string> first,
                                       const std::vector<std::string>& second) {
    first.insert(first.end(), second.begin() + 1, second.end());
    return first;
  }

  rt::Subscription sent_;
};

inline int tries() {
  const char* text = std::getenv("TANDEM_FAULT_TRIES");
  return text ? std::max(1, std::atoi(text)) : 1;
}

inline void print(const std::vector<Row>& rows) {
  std::printf("\n%-52s %5s %10s %28s\n", "fault", "tries", "collisions", "to stand [s] p50 / max");
  for (const Row& row : rows) {
    std::vector<double> t = row.to_stand;
    std::sort(t.begin(), t.end());
    if (t.empty())
      std::printf("%-52s %5d %10u %28s\n", row.name.c_str(), row.tries, row.collisions,
                  "may drive on");
    else
      std::printf("%-52s %5d %10u %20.2f / %.2f\n", row.name.c_str(), row.tries, row.collisions,
                  t[t.size() / 2], t.back());
  }
}

template <class System>
class FaultTest : public ::testing::Test {
 protected:
  template <class... Args>
  explicit FaultTest(Args... args) : system_{args...} {}

  void suffer(const std::vector<Fault>& faults) {
    std::vector<Row> rows;
    for (const Fault& fault : faults) {
      rows.push_back({fault.name, 0, 0, {}});
      for (int i = 0; i < tries() && !HasFatalFailure(); ++i) suffer(fault, rows.back());
    }
    print(rows);
  }

  // The robot may have to brake from its highest speed since the fault.
  void suffer(const Fault& fault, Row& row) {
    SCOPED_TRACE(fault.name);
    ASSERT_TRUE(system_.wait_until_driving());
    const unsigned collisions_before = system_.collisions;
    const double began = system_.sim_time;
    double v = 0.0, w = 0.0;
    system_.forget();
    fault.begin();
    const auto watch = [&] {
      v = std::max(v, std::abs(system_.truth.twist.v));
      w = std::max(w, std::abs(system_.truth.twist.w));
    };
    ++row.tries;
    if (fault.stands()) {
      EXPECT_TRUE(system_.wait_until([&] { return watch(), system_.stands(); }, 5.0));
      const double took = system_.sim_time - began;
      row.to_stand.push_back(took);
      EXPECT_LE(took,
                fault.zero_within + std::max(v / kBraking, w / kTurnBraking) + 2 * kOdomPeriod);
    }
    EXPECT_TRUE(system_.wait_until([&] { return system_.said(fault.reason, fault.told); }, 5.0))
        << "`" << fault.reason << "` is not reported; " << system_.sayings();
    const double lasts = fault.stands() || fault.done ? fault.lasts : std::max(fault.lasts, kLasts);
    EXPECT_TRUE(system_.wait_until([&] { return system_.sim_time >= began + lasts; }, lasts + 5.0));
    if (fault.done) {
      EXPECT_TRUE(system_.wait_until(fault.done, 20.0)) << "not all of it happened";
    }
    fault.end();
    EXPECT_TRUE(system_.wait_until_driving()) << "does not drive on";
    row.collisions += system_.collisions - collisions_before;
    EXPECT_EQ(system_.collisions, collisions_before);
  }

  System system_;
};

class Faults : public FaultTest<RelayedSystem> {
 protected:
  using FaultTest::FaultTest;
  ~Faults() override { EXPECT_EQ(system_.unsound, 0); }

  // Drops all messages of a link.
  template <class M>
  [[nodiscard]] static Fault lost(const char* name, Relay<M>& relay, const char* reason) {
    return {std::string{name} + " lost", [&relay] { relay.drop(); }, [&relay] { relay.pass(); },
            reason};
  }
  template <class M>
  [[nodiscard]] static Fault spoiled(const char* name, Relay<M>& relay,
                                     std::function<void(M&)> spoil, const char* reason = nullptr) {
    return {name, [&relay, spoil] { relay.spoil(spoil); }, [&relay] { relay.pass(); }, reason};
  }
};

}  // namespace tandem::test
