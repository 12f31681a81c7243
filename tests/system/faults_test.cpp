// SPDX-License-Identifier: Apache-2.0
// Everything that can go wrong between processes, while the robot drives through the forest over
// real DDS: it touches nothing, stands within its bound, somebody says why, and it drives on
// afterwards. Prints a table; TANDEM_FAULT_TRIES=n tries each fault n times.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>

#include "system/relay.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

constexpr double kZeroWithin = 0.2;   // [s] from the fault to a command of zero
constexpr double kBraking = 1.5;      // [m/s²] a_brake of bringup/robots/mir100.yaml
constexpr double kTurnBraking = 3.0;  // [rad/s²] alpha_brake
constexpr double kOdomPeriod = 0.02;  // [s] between two ground truths: what we can see
constexpr double kNoTransform = 1.0;  // [s] of silence of map → odom until a command of zero
constexpr double kLasts = 1.0;        // [s] that a fault lasts which need not stop the robot

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// What goes wrong, and what must come of it.
struct Fault {
  std::string name;
  std::function<void()> begin, end;
  const char* reason = nullptr;  ///< that somebody gives; null: nobody has to
  bool stands = true;            ///< false: it may drive on through it
  double zero_within = kZeroWithin;
};

struct Row {
  std::string name;
  int tries = 0;
  unsigned collisions = 0;
  std::vector<double> to_stand;  // [s] simulated
};

/// The forest's system with a relay in each of its links.
class FaultySystem : public SystemUnderTest {
 public:
  FaultySystem() {
    filter_ = node().create_subscription(topics::filter_status,
                                         [this](const auto& msg) { say(msg.reason()); });
    diagnostics_ = node().create_subscription(topics::diagnostics, [this](const auto& msg) {
      for (const auto& status : msg.status()) say(status.message());
    });
    sent_ = node().create_subscription(
        rt::Topic<geometry_msgs::msg::Twist>{"cmd_vel_raw", topics::cmd_vel.qos},
        [this](const auto& msg) { unsound += from_msg(msg) ? 0 : 1; });
    for (const char* name : kComponents) start_relayed(name);
  }

  void start_relayed(const std::string& name) { start(name, remappings(name)); }

  [[nodiscard]] bool said(const char* why) const {
    return why == nullptr || said_.contains(why) || reason == why || planner_says == why;
  }
  void forget() { said_.clear(); }

  int unsound = 0;  ///< commands of the filter that were not finite

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

 private:
  void say(const std::string& text) { said_.insert(text); }

  [[nodiscard]] std::vector<std::string> remappings(const std::string& name) const {
    if (name == "driver") return joy.remapping();
    if (name == "obstacle_extractor") return obstacles.remapping();
    if (name == "local_planner") return shared.remapping();
    if (name == "arbitration") return arbitrated.remapping();
    if (name == "safety_filter") return cmd_vel.remapping();
    if (name == "map_server") return map.remapping();
    if (name == "diff_drive_sim") return both(odom.remapping(), tf.remapping());
    if (name == "teleop") return both(user.remapping(), leader.remapping());
    return {};
  }
  // The second without its --ros-args.
  static std::vector<std::string> both(std::vector<std::string> first,
                                       const std::vector<std::string>& second) {
    first.insert(first.end(), second.begin() + 1, second.end());
    return first;
  }

  std::set<std::string> said_;
  rt::Subscription filter_, diagnostics_, sent_;
};

int tries() {
  const char* text = std::getenv("TANDEM_FAULT_TRIES");
  return text ? std::max(1, std::atoi(text)) : 1;
}

void print(const std::vector<Row>& rows) {
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

class Faults : public ::testing::Test {
 protected:
  void suffer(const std::vector<Fault>& faults) {
    std::vector<Row> rows;
    for (const Fault& fault : faults) {
      rows.push_back({fault.name, 0, 0, {}});
      for (int i = 0; i < tries() && !HasFatalFailure(); ++i) suffer(fault, rows.back());
    }
    print(rows);
    EXPECT_EQ(system_.unsound, 0);
  }

  // The velocity that may have to be braked is the largest since the fault.
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
    if (fault.stands) {
      EXPECT_TRUE(system_.wait_until([&] { return watch(), system_.stands(); }, 5.0));
      const double took = system_.sim_time - began;
      row.to_stand.push_back(took);
      EXPECT_LE(took,
                fault.zero_within + std::max(v / kBraking, w / kTurnBraking) + 2 * kOdomPeriod);
    }
    EXPECT_TRUE(system_.wait_until([&] { return system_.said(fault.reason); }, 5.0))
        << "nobody says `" << fault.reason << "`";
    if (!fault.stands) {
      EXPECT_TRUE(system_.wait_until([&] { return system_.sim_time > began + kLasts; }, 5.0));
    }
    fault.end();
    EXPECT_TRUE(system_.wait_until_driving()) << "does not drive on";
    row.collisions += system_.collisions - collisions_before;
    EXPECT_EQ(system_.collisions, collisions_before);
  }

  // Loses all messages of a link.
  template <class M>
  [[nodiscard]] static Fault lost(const char* name, Relay<M>& relay, const char* reason) {
    return {std::string{name} + " lost", [&relay] { relay.drop(); }, [&relay] { relay.pass(); },
            reason};
  }
  template <class M>
  [[nodiscard]] static Fault spoiled(const char* name, Relay<M>& relay,
                                     std::function<void(M&)> spoil, const char* reason,
                                     bool stands) {
    return {name, [&relay, spoil] { relay.spoil(spoil); }, [&relay] { relay.pass(); }, reason,
            stands};
  }

  FaultySystem system_;
};

// Sets one number of a message after the other to NaN, +∞ and −∞, one per message.
template <class M>
std::function<void(M&)> each_number(std::vector<std::function<void(M&, double)>> setters) {
  return [setters, i = std::size_t{0}](M& msg) mutable {
    const double values[] = {kNaN, kInf, -kInf};
    setters[i / 3 % setters.size()](msg, values[i % 3]);
    ++i;
  };
}

using Twist = geometry_msgs::msg::Twist;
using Odom = nav_msgs::msg::Odometry;
using LeaderPose = geometry_msgs::msg::PoseStamped;
using Obstacles = tandem_msgs::msg::ObstacleArray;
using Joy = sensor_msgs::msg::Joy;
using Tf = tf2_msgs::msg::TFMessage;

std::function<void(Twist&)> each_twist() {
  return each_number<Twist>(
      {[](Twist& m, double x) { m.linear().x(x); }, [](Twist& m, double x) { m.linear().y(x); },
       [](Twist& m, double x) { m.linear().z(x); }, [](Twist& m, double x) { m.angular().x(x); },
       [](Twist& m, double x) { m.angular().y(x); }, [](Twist& m, double x) { m.angular().z(x); }});
}

template <class M, class Pose>
std::vector<std::function<void(M&, double)>> pose_numbers(Pose pose) {
  return {[=](M& m, double x) { pose(m).position().x(x); },
          [=](M& m, double x) { pose(m).position().y(x); },
          [=](M& m, double x) { pose(m).position().z(x); },
          [=](M& m, double x) { pose(m).orientation().x(x); },
          [=](M& m, double x) { pose(m).orientation().y(x); },
          [=](M& m, double x) { pose(m).orientation().z(x); },
          [=](M& m, double x) { pose(m).orientation().w(x); }};
}

std::function<void(Odom&)> each_odom() {
  auto all = pose_numbers<Odom>([](Odom & m) -> auto& { return m.pose().pose(); });
  all.push_back([](Odom& m, double x) { m.twist().twist().linear().x(x); });
  all.push_back([](Odom& m, double x) { m.twist().twist().angular().z(x); });
  all.push_back([](Odom& m, double x) { m.pose().covariance()[0] = x; });
  return each_number<Odom>(std::move(all));
}

std::function<void(Obstacles&)> each_obstacle() {
  using Number = std::function<void(tandem_msgs::msg::Obstacle&, double)>;
  const std::vector<Number> numbers{
      [](auto& o, double x) { o.center().x(x); },  [](auto& o, double x) { o.center().y(x); },
      [](auto& o, double x) { o.semi_axis_a(x); }, [](auto& o, double x) { o.semi_axis_b(x); },
      [](auto& o, double x) { o.angle(x); },       [](auto& o, double x) { o.velocity().x(x); }};
  std::vector<std::function<void(Obstacles&, double)>> all;
  for (const auto& number : numbers)
    all.push_back([number](Obstacles& m, double x) {
      for (auto& obstacle : m.obstacles()) number(obstacle, x);
    });
  return each_number<Obstacles>(std::move(all));
}

TEST_F(Faults, OfLinks) {
  auto& s = system_;
  const char* no_user = "cmd_vel_user is silent";
  const std::function<void(Odom&)> a_metre_off = [](Odom& m) {
    m.pose().pose().position().x(m.pose().pose().position().x() + 1.0);
  };
  const std::function<void(Tf&)> map_off = [](Tf& m) {
    for (auto& transform : m.transforms())
      if (transform.header().frame_id() == "map") transform.transform().translation().y() += 1.0;
  };
  const std::function<void(Odom&)> noisy = [random = std::mt19937{1}](Odom& m) mutable {
    std::uniform_real_distribution<double> off(-0.007, 0.007);  // [m], the filter's bound in both
    m.pose().pose().position().x() += off(random);
    m.pose().pose().position().y() += off(random);
  };
  const auto cut = [](octomap_msgs::msg::Octomap& m) { m.data().resize(m.data().size() / 2); };
  Fault no_transform = lost("tf", s.tf, "not localized");
  no_transform.zero_within = kNoTransform + kZeroWithin;
  suffer({lost("joy", s.joy, no_user),
          lost("cmd_vel_user", s.user, no_user),
          lost("leader_pose", s.leader, "leader_pose is silent"),
          lost("obstacles", s.obstacles, "obstacles are silent"),
          lost("cmd_vel_shared", s.shared, "cmd_vel_shared is silent"),
          lost("cmd_vel_arbitrated", s.arbitrated, "no command"),
          lost("cmd_vel (the base's own time-out)", s.cmd_vel, nullptr),
          lost("odom", s.odom, "not localized"),
          spoiled("odom jumps by 1 m, and back", s.odom, a_metre_off, "pose jumped", true),
          no_transform,
          spoiled("tf jumps by 1 m, and back", s.tf, map_off, "pose jumped", true),
          spoiled("odom off by up to 1 cm, each by another", s.odom, noisy, nullptr, false),
          {"half a map after the whole one", [&s, cut] { s.map.say_again(cut); }, [] {}, nullptr,
           false}});
}

TEST_F(Faults, OfNumbers) {
  auto& s = system_;
  const std::function<void(Twist&)> no_speed = [](Twist& m) { m.linear().x(kNaN); };
  const std::function<void(Twist&)> nonsense = [sign = 1.0](Twist& m) mutable {
    sign = -sign;
    m.linear().x(1e9 * sign);
    m.angular().z(1e9 * sign);
  };
  const std::function<void(Odom&)> no_place = [](Odom& m) { m.pose().pose().position().x(kInf); };
  suffer({spoiled("cmd_vel_user NaN", s.user, no_speed, "cmd_vel_user is silent", true),
          spoiled("cmd_vel_shared NaN", s.shared, no_speed, "cmd_vel_shared is silent", true),
          spoiled("cmd_vel_arbitrated NaN", s.arbitrated, no_speed, "command not finite", true),
          spoiled("cmd_vel_shared 1e9 to and fro", s.shared, nonsense, nullptr, false),
          spoiled("cmd_vel NaN", s.cmd_vel, no_speed, nullptr, true),
          spoiled("odom at infinity", s.odom, no_place, "not localized", true),
          spoiled("NaN, inf in each of joy", s.joy,
                  each_number<Joy>({[](Joy& m, double x) { m.axes()[0] = static_cast<float>(x); },
                                    [](Joy& m, double x) { m.axes()[1] = static_cast<float>(x); }}),
                  nullptr, false),
          spoiled("NaN, inf in each of cmd_vel_user", s.user, each_twist(), nullptr, false),
          spoiled("NaN, inf in each of leader_pose", s.leader,
                  each_number<LeaderPose>(
                      pose_numbers<LeaderPose>([](LeaderPose & m) -> auto& { return m.pose(); })),
                  nullptr, false),
          spoiled("NaN, inf in each of obstacles", s.obstacles, each_obstacle(), nullptr, false),
          spoiled("NaN, inf in each of cmd_vel_shared", s.shared, each_twist(), nullptr, false),
          spoiled("NaN, inf in each of cmd_vel_arbitrated", s.arbitrated, each_twist(), nullptr,
                  false),
          spoiled("NaN, inf in each of cmd_vel", s.cmd_vel, each_twist(), nullptr, false),
          spoiled("NaN, inf in each of odom", s.odom, each_odom(), nullptr, false)});
}

TEST_F(Faults, OfTime) {
  auto& s = system_;
  const auto on = [](auto& relay, auto change) {
    return std::function<void()>{[&relay, change] { change(relay); }};
  };
  const auto off = [](auto& relay) { return std::function<void()>{[&relay] { relay.pass(); }}; };
  const auto half = [](auto& relay) { relay.lose(0.5); };
  const auto late = [](auto& relay) { relay.delay(0.0, 0.5); };
  const auto thrice = [](auto& relay) { relay.repeat(3); };
  suffer(
      {{"half of joy lost", on(s.joy, half), off(s.joy), nullptr, false},
       {"half of cmd_vel_user lost", on(s.user, half), off(s.user), nullptr, false},
       {"half of cmd_vel_shared lost", on(s.shared, half), off(s.shared), nullptr, false},
       {"half of cmd_vel lost", on(s.cmd_vel, half), off(s.cmd_vel), nullptr, false},
       {"half of odom lost", on(s.odom, half), off(s.odom), nullptr, false},
       {"joy 0-0.5 s late, out of order", on(s.joy, late), off(s.joy), nullptr, false},
       {"cmd_vel_user 0-0.5 s late, out of order", on(s.user, late), off(s.user), nullptr, false},
       {"cmd_vel_shared 0-0.5 s late, out of order", on(s.shared, late), off(s.shared), nullptr,
        false},
       {"cmd_vel_arbitrated 0-0.5 s late", on(s.arbitrated, late), off(s.arbitrated), nullptr,
        false},
       {"obstacles 0-0.5 s late, out of order", on(s.obstacles, late), off(s.obstacles), nullptr,
        false},
       {"cmd_vel_shared three times", on(s.shared, thrice), off(s.shared), nullptr, false},
       {"cmd_vel three times", on(s.cmd_vel, thrice), off(s.cmd_vel), nullptr, false}});
}

// A second robot on the same names, or a second person at the stick.
TEST_F(Faults, OfStrangers) {
  auto& s = system_;
  const auto intruded = [](const char* name, auto& relay, auto spoil, const char* reason,
                           bool stands) {
    return Fault{name, [&relay, spoil] { relay.intrude(spoil); }, [&relay] { relay.pass(); },
                 reason, stands};
  };
  const auto full_ahead = [](Twist& m) {
    m.linear().x(0.8);
    m.angular().z(0.0);
  };
  suffer({intruded(
              "odom of a second robot", s.odom, [](Odom& m) { m.pose().pose().position().y(3.0); },
              "pose jumped", true),
          intruded(
              "obstacles of a second robot: none", s.obstacles,
              [](Obstacles& m) { m.obstacles({}); }, nullptr, false),
          intruded(
              "joy of a second person: back", s.joy,
              [](Joy& m) {
                m.axes({0.0F, -1.0F});
              },
              nullptr, false),
          intruded("cmd_vel_shared of a second robot: full ahead", s.shared, full_ahead, nullptr,
                   false),
          intruded("cmd_vel_arbitrated of a second robot: full ahead", s.arbitrated, full_ahead,
                   nullptr, false)});
}

TEST_F(Faults, OfProcesses) {
  const std::pair<const char*, const char*> victims[] = {
      {"driver", "cmd_vel_user is silent"},
      {"teleop", "cmd_vel_user is silent"},
      {"obstacle_extractor", "obstacles are silent"},
      {"local_planner", "cmd_vel_shared is silent"},
      {"arbitration", "no command"},
      {"safety_filter", nullptr}};
  std::vector<Fault> faults;
  for (const auto& [victim, reason] : victims) {
    const std::string name = victim;
    faults.push_back({name + " stopped, then continued",
                      [this, name] { system_.process(name).send(SIGSTOP); },
                      [this, name] { system_.process(name).send(SIGCONT); }, reason});
    faults.push_back({name + " killed, then started again",
                      // Not waited for: the relays are ours and must go on meanwhile.
                      [this, name] { system_.process(name).send(SIGKILL); },
                      [this, name] { system_.start_relayed(name); }, reason});
  }
  faults.push_back({"map_server killed, then started again",
                    [this] { system_.process("map_server").send(SIGKILL); },
                    [this] { system_.start_relayed("map_server"); }, nullptr, false});
  suffer(faults);
}

// What was under way when a process stopped is not carried out when it comes back.
TEST_F(Faults, NoOldCommandComesBack) {
  ASSERT_TRUE(system_.wait_until_driving());
  system_.process("safety_filter").send(SIGSTOP);
  ASSERT_TRUE(system_.wait_until([&] { return system_.stands(); }, 5.0));
  system_.process("driver").send(SIGSTOP);  // nobody wants to drive any more
  ASSERT_TRUE(system_.wait_until([&] { return system_.reason == "cmd_vel_user is silent"; }, 5.0));
  // The last command that was meant may still be carried out for its lifespan; none is meanwhile.
  const double silent = system_.sim_time;
  ASSERT_TRUE(system_.wait_until([&] { return system_.sim_time > silent + kLasts; }, 10.0));
  ASSERT_EQ(system_.reason, "cmd_vel_user is silent");
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

}  // namespace
}  // namespace tandem::test
