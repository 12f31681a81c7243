// SPDX-License-Identifier: Apache-2.0
// Everything that can go wrong between processes, while the robot drives through the forest over
// real DDS: it touches nothing, stands within its bound, somebody says why, and it drives on
// afterwards. Prints a table; TANDEM_FAULT_TRIES=n tries each fault n times.
#include <limits>
#include <random>

#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

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

}  // namespace
}  // namespace tandem::test
