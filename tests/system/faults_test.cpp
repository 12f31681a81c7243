// SPDX-License-Identifier: Apache-2.0
// Injects faults between processes while the robot drives through the forest over real DDS. The
// robot must touch nothing, stop within its bound, report why, and drive on afterwards. Prints a
// table; TANDEM_FAULT_TRIES=n tries each fault n times.
#include <limits>
#include <memory>
#include <optional>
#include <random>

#include "support/paths.hpp"
#include "system/faulty_system.hpp"
#include "system/not_finite.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNumbersLast = 1.0;  // [s] at least; there is no more to come of it

using Twist = geometry_msgs::msg::Twist;
using Odom = nav_msgs::msg::Odometry;
using LeaderPose = geometry_msgs::msg::PoseStamped;
using Obstacles = tandem_msgs::msg::ObstacleArray;
using Joy = sensor_msgs::msg::Joy;
using Tf = tf2_msgs::msg::TFMessage;

// A fault that sets one number of a message at a time to NaN, +∞ and −∞, one per message, and lasts
// until each was sent.
template <class M>
Fault each_number(const char* name, Relay<M>& relay, Setters<M> setters) {
  const auto sent = std::make_shared<std::size_t>(0);
  const std::size_t all = 3 * setters.size();
  const auto spoil = [setters = std::move(setters), sent](M& msg) {
    setters[*sent / 3 % setters.size()](msg, kNotFinite[*sent % 3]);
    ++*sent;
  };
  Fault fault;
  fault.name = std::string{"NaN, inf in each of "} + name;
  fault.begin = [&relay, spoil, sent] {
    *sent = 0;
    relay.spoil(spoil);
  };
  fault.end = [&relay] { relay.pass(); };
  fault.lasts = kNumbersLast;
  fault.done = [sent, all] { return *sent >= all; };
  return fault;
}

Setters<Twist> command_numbers() {
  return twist_numbers<Twist>([](Twist & m) -> auto& { return m; });
}

Setters<Odom> odom_numbers() {
  auto all = pose_numbers<Odom>([](Odom & m) -> auto& { return m.pose().pose(); });
  for (auto& setter : twist_numbers<Odom>([](Odom & m) -> auto& { return m.twist().twist(); }))
    all.push_back(std::move(setter));
  all.push_back([](Odom& m, double x) { m.pose().covariance().fill(x); });
  all.push_back([](Odom& m, double x) { m.twist().covariance().fill(x); });
  return all;
}

// Applies the fault to map → odom and odom → base_link at once.
Setters<Tf> tf_numbers() {
  using Number = std::function<void(geometry_msgs::msg::Transform&, double)>;
  const std::vector<Number> numbers{[](auto& t, double x) { t.translation().x(x); },
                                    [](auto& t, double x) { t.translation().y(x); },
                                    [](auto& t, double x) { t.translation().z(x); },
                                    [](auto& t, double x) { t.rotation().x(x); },
                                    [](auto& t, double x) { t.rotation().y(x); },
                                    [](auto& t, double x) { t.rotation().z(x); },
                                    [](auto& t, double x) { t.rotation().w(x); }};
  Setters<Tf> all;
  for (const auto& number : numbers)
    all.push_back([number](Tf& m, double x) {
      for (auto& transform : m.transforms()) number(transform.transform(), x);
    });
  return all;
}

Setters<Obstacles> obstacle_numbers() {
  using Number = std::function<void(tandem_msgs::msg::Obstacle&, double)>;
  const std::vector<Number> numbers{
      [](auto& o, double x) { o.center().x(x); },   [](auto& o, double x) { o.center().y(x); },
      [](auto& o, double x) { o.center().z(x); },   [](auto& o, double x) { o.semi_axis_a(x); },
      [](auto& o, double x) { o.semi_axis_b(x); },  [](auto& o, double x) { o.angle(x); },
      [](auto& o, double x) { o.velocity().x(x); }, [](auto& o, double x) { o.velocity().y(x); },
      [](auto& o, double x) { o.velocity().z(x); }};
  Setters<Obstacles> all;
  for (const auto& number : numbers)
    all.push_back([number](Obstacles& m, double x) {
      for (auto& obstacle : m.obstacles()) number(obstacle, x);
    });
  return all;
}

TEST_F(Faults, OfLinks) {
  auto& s = system_;
  const char* no_user = "cmd_vel_user is silent";
  const char* jumped = "safety filter: pose jumped";
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
  Fault no_transform = lost("tf", s.tf, "safety filter: not localized");
  no_transform.zero_within = kNoTransform + kZeroWithin;
  Fault no_wheels = lost("cmd_vel (the base's own time-out)", s.cmd_vel, nullptr);
  no_wheels.told = Told::kNowhere;
  suffer({lost("joy", s.joy, no_user),
          lost("cmd_vel_user", s.user, no_user),
          lost("leader_pose", s.leader, "planner: leader_pose is silent"),
          lost("obstacles", s.obstacles, "planner: obstacles are silent"),
          lost("cmd_vel_shared", s.shared, "cmd_vel_shared is silent"),
          lost("cmd_vel_arbitrated", s.arbitrated, "safety filter: no command"),
          no_wheels,
          lost("odom", s.odom, "safety filter: not localized"),
          spoiled("odom jumps by 1 m, and back", s.odom, a_metre_off, jumped),
          no_transform,
          spoiled("tf jumps by 1 m, and back", s.tf, map_off, jumped),
          spoiled("odom off by up to 1 cm, each by another", s.odom, noisy),
          {"half a map after the whole one", [&s, cut] { s.map.say_again(cut); }, [] {}}});
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
  Fault no_wheels = spoiled("cmd_vel NaN", s.cmd_vel, no_speed);
  no_wheels.told = Told::kNowhere;
  suffer({spoiled("cmd_vel_user NaN", s.user, no_speed, "cmd_vel_user is silent"),
          spoiled("cmd_vel_shared NaN", s.shared, no_speed, "cmd_vel_shared is silent"),
          spoiled("cmd_vel_arbitrated NaN", s.arbitrated, no_speed,
                  "safety filter: command not finite"),
          spoiled("cmd_vel_shared 1e9 to and fro", s.shared, nonsense), no_wheels,
          spoiled("odom at infinity", s.odom, no_place, "safety filter: not localized"),
          each_number<Joy>("joy", s.joy,
                           {[](Joy& m, double x) { m.axes()[0] = static_cast<float>(x); },
                            [](Joy& m, double x) { m.axes()[1] = static_cast<float>(x); }}),
          each_number("cmd_vel_user", s.user, command_numbers()),
          each_number("leader_pose", s.leader,
                      pose_numbers<LeaderPose>([](LeaderPose & m) -> auto& { return m.pose(); })),
          each_number("obstacles", s.obstacles, obstacle_numbers()),
          each_number("cmd_vel_shared", s.shared, command_numbers()),
          each_number("cmd_vel_arbitrated", s.arbitrated, command_numbers()),
          each_number("cmd_vel", s.cmd_vel, command_numbers()),
          each_number("odom", s.odom, odom_numbers()), each_number("tf", s.tf, tf_numbers())});
}

// Relays of several links that all behave alike.
template <class Change, class... Relays>
Fault to_all(const char* name, Change change, Relays&... relays) {
  return {name, [=, &relays...] { (change(relays), ...); }, [&relays...] { (relays.pass(), ...); }};
}

TEST_F(Faults, OfTime) {
  auto& s = system_;
  const auto half = [](auto& relay) { relay.lose(0.5); };
  const auto late = [](auto& relay) { relay.delay(0.0, 0.5); };
  const auto thrice = [](auto& relay) { relay.repeat(3); };
  Fault all_late = to_all(
      "odom, tf 0.5 s late, each of them", [](auto& relay) { relay.delay(0.5, 0.5); }, s.odom,
      s.tf);
  all_late.reason = "safety filter: not localized";
  all_late.lasts = 1.5;  // it comes again, and it is old
  suffer({to_all("half of joy, cmd_vel_user, leader_pose lost", half, s.joy, s.user, s.leader),
          to_all("half of obstacles, cmd_vel_shared lost", half, s.obstacles, s.shared),
          to_all("half of cmd_vel_arbitrated, cmd_vel lost", half, s.arbitrated, s.cmd_vel),
          to_all("half of odom, tf lost", half, s.odom, s.tf),
          to_all("joy 0-0.5 s late, out of order", late, s.joy),
          to_all("cmd_vel_user, leader_pose 0-0.5 s late, out of order", late, s.user, s.leader),
          to_all("obstacles 0-0.5 s late, out of order", late, s.obstacles),
          to_all("cmd_vel_shared 0-0.5 s late, out of order", late, s.shared),
          to_all("cmd_vel_arbitrated 0-0.5 s late, out of order", late, s.arbitrated),
          to_all("odom, tf 0-0.5 s late, out of order", late, s.odom, s.tf), all_late,
          to_all("joy, cmd_vel_user, leader_pose, obstacles thrice", thrice, s.joy, s.user,
                 s.leader, s.obstacles),
          to_all("cmd_vel_shared, _arbitrated, cmd_vel, odom, tf thrice", thrice, s.shared,
                 s.arbitrated, s.cmd_vel, s.odom, s.tf)});
}

// Uses TwistStamped for the filter's commands, and a base that drops commands older than the filter
// assumes. A plain Twist has no timestamp except its send time, which a relaying node renews:
// nothing can be guaranteed if it arrives later than `command_delay`.
class StampedSystem : public WatchedSystem {
 public:
  StampedSystem() {
    told_ = node().create_subscription(topics::cmd_vel_stamped, [this](const auto& msg) {
      if (const auto twist = from_msg(msg.twist())) command = *twist;
    });
    for (const std::string name : kComponents) start(name, arguments(name));
  }

  Relay<geometry_msgs::msg::TwistStamped> cmd_vel{node(), topics::cmd_vel_stamped};

 private:
  [[nodiscard]] std::vector<std::string> arguments(const std::string& name) const {
    if (name == "diff_drive_sim") return {"--ros-args", "-p", "max_stamp_age:=0.05"};
    if (name != "safety_filter") return {};
    std::vector<std::string> all = cmd_vel.remapping();
    all.insert(all.end(), {"-p", "stamped:=true", "-p", "command_delay:=0.05"});
    return all;
  }

  rt::Subscription told_;
};

class StampedFaults : public FaultTest<StampedSystem> {};

TEST_F(StampedFaults, OfTheLastLink) {
  auto& s = system_;
  const auto late = [](double least) { return [least](auto& relay) { relay.delay(least, 0.5); }; };
  Fault all_late = to_all("cmd_vel (stamped) 0.5 s late, each of them", late(0.5), s.cmd_vel);
  all_late.told = Told::kNowhere;
  suffer({to_all("cmd_vel (stamped) 0-0.5 s late, out of order", late(0.0), s.cmd_vel), all_late});
}

// A second robot on the same names, or a second person at the controls.
TEST_F(Faults, OfStrangers) {
  auto& s = system_;
  const auto intruded = [](const char* name, auto& relay, auto spoil,
                           const char* reason = nullptr) {
    return Fault{name, [&relay, spoil] { relay.intrude(spoil); }, [&relay] { relay.pass(); },
                 reason};
  };
  const auto full_ahead = [](Twist& m) {
    m.linear().x(0.8);
    m.angular().z(0.0);
  };
  const auto elsewhere = [](Tf& m) {
    for (auto& transform : m.transforms()) transform.transform().translation().y(3.0);
  };
  octomap_msgs::msg::Octomap hall;
  const auto tree = load_octomap(source_path("maps/hall.bt"));
  hall.binary(true);
  hall.id("OcTree");
  hall.resolution(tree->getResolution());
  hall.data(encode_octomap(*tree));
  std::optional<rt::Publisher<octomap_msgs::msg::Octomap>> other;
  const Fault another_map{"octomap_binary of a second robot: an empty hall",
                          [&] {
                            other.emplace(system_.node().create_publisher(topics::octomap_binary));
                            other->publish(hall);  // latched
                          },
                          [&] { other.reset(); }};
  suffer({another_map,
          intruded(
              "odom of a second robot", s.odom, [](Odom& m) { m.pose().pose().position().y(3.0); },
              "safety filter: pose jumped"),
          intruded("tf of a second robot", s.tf, elsewhere, "safety filter: pose jumped"),
          intruded("obstacles of a second robot: none", s.obstacles,
                   [](Obstacles& m) { m.obstacles({}); }),
          intruded("joy of a second person: back", s.joy,
                   [](Joy& m) {
                     m.axes({0.0F, -1.0F});
                   }),
          intruded("cmd_vel_user of a second person: full ahead", s.user, full_ahead),
          intruded("leader_pose of a second person: elsewhere", s.leader,
                   [](LeaderPose& m) {
                     m.pose().position().x(3.0);
                     m.pose().position().y(3.0);
                   }),
          intruded("cmd_vel_shared of a second robot: full ahead", s.shared, full_ahead),
          intruded("cmd_vel_arbitrated of a second robot: full ahead", s.arbitrated, full_ahead)});
}

}  // namespace
}  // namespace tandem::test
