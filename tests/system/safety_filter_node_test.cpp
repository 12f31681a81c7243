// SPDX-License-Identifier: Apache-2.0
// Tests the safety filter over DDS: map, odometry, people and other publishers of cmd_vel.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/paths.hpp"
#include "system/not_finite.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {
namespace {

class FilterOverDds : public OneComponent {
 protected:
  explicit FilterOverDds(const std::string& people = "false")
      : filter_{load("safety_filter", {{"map_is_odom", "true"}, {"people", people}})} {
    out_ = node_.create_subscription(topics::cmd_vel,
                                     [this](const auto& msg) { v_ = msg.linear().x(); });
    status_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
      reason_ = from_msg(msg.reason_code());
      ++reports_[reason_];
      if (from_msg(msg.passed()) != Twist2{}) ++driven_;
    });
    beat_ = node_.create_wall_timer(0.02, [this] { beat(); });
  }
  void beat() {
    odom_.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
    if (other_) odom_.publish(to_msg(Odometry{*other_, {}}, header({}, "odom"), "base_link"));
    command_.publish(to_msg(Twist2{push_v_, 0.0}));
  }
  void send_map(std::vector<std::int8_t> data) {
    octomap_msgs::msg::Octomap msg;
    msg.binary(true);
    msg.id("OcTree");
    msg.resolution(0.05);
    msg.data(std::move(data));
    map_.publish(msg);
  }

  rt::RunningComponent filter_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Publisher<octomap_msgs::msg::Octomap> map_ = node_.create_publisher(topics::octomap_binary);
  rt::Subscription out_, status_;
  rt::Timer beat_;
  double push_v_ = 0.3, v_ = -1.0;
  std::optional<Pose2> other_;  ///< another robot's pose, published right after this robot's own
  Reason reason_ = Reason::kNone;
  std::map<Reason, int> reports_;  ///< how often each reason was reported
  int driven_ = 0;                 ///< reports with a nonzero command
};

TEST_F(FilterOverDds, StandsWithoutAMapAndDrivesWithOne) {
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kNoMapYet; }));
  send_map(encode_octomap(*load_octomap(source_path("maps/yard.bt"))));
  EXPECT_TRUE(wait_until([&] { return v_ == 0.3 && reason_ == Reason::kClear; }));
}

class FilterAmongPeople : public FilterOverDds {
 protected:
  FilterAmongPeople() : FilterOverDds{"true"} {
    send_map(encode_octomap(*load_octomap(source_path("maps/yard.bt"))));
    people_beat_ = node_.create_wall_timer(0.02, [this] {
      if (list_) people_.publish(to_msg(*list_, header({}, frame_)));
    });
  }
  // A person this far ahead of base_link, as a list of one.
  static std::vector<Obstacle> somebody(double x) {
    return {{.p_MO = {x, 0.0}, .a = 0.25, .b = 0.25}};
  }

  rt::Publisher<tandem_msgs::msg::ObstacleArray> people_ = node_.create_publisher(topics::people);
  rt::Timer people_beat_;
  std::optional<std::vector<Obstacle>> list_;
  std::string frame_ = "map";
};

TEST_F(FilterAmongPeople, SlowsForAPersonAheadAndStandsWhenPeopleIsSilent) {
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
  list_.emplace();
  ASSERT_TRUE(
      wait_until([&] { return v_ == 0.3 && reason_ == Reason::kClear; }));  // nobody is there
  list_ = somebody(0.85);
  ASSERT_TRUE(wait_until([&] { return v_ < 0.1 && reason_ == Reason::kSlowed; }));
  list_.emplace();
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  list_.reset();
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
}

TEST_F(FilterAmongPeople, AListWithAnInvalidEntryIsIgnored) {
  list_ = somebody(5.0);
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  list_->push_back(somebody(kNaN).front());
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
  list_->pop_back();
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  frame_ = "camera";
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
}

// Another robot's tracker reports an empty list, and at a higher rate.
TEST_F(FilterAmongPeople, ListsFromTwoPublishersAreIgnored) {
  list_ = somebody(5.0);
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  const auto other = node_.create_publisher(topics::people);
  auto others_beat = node_.create_wall_timer(
      0.007, [&] { other.publish(to_msg(std::vector<Obstacle>{}, header({}, frame_))); });
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
  reports_.clear();
  driven_ = 0;
  // On a busy computer it may stand for a late command, too.
  ASSERT_TRUE(wait_until([&] { return reports_[Reason::kPeopleSilent] > 100; }));
  EXPECT_EQ(driven_, 0);
  others_beat = {};
  EXPECT_TRUE(wait_until([&] { return v_ == 0.3 && reason_ == Reason::kClear; }));
}

TEST_F(FilterAmongPeople, IgnoresAListWithAnyNonFiniteNumber) {
  people_beat_ = {};
  using Person = tandem_msgs::msg::Obstacle;
  const std::pair<const char*, std::function<void(Person&, double)>> numbers[] = {
      {"center.x", [](Person& o, double x) { o.center().x(x); }},
      {"center.y", [](Person& o, double x) { o.center().y(x); }},
      {"semi_axis_a", [](Person& o, double x) { o.semi_axis_a(x); }},
      {"semi_axis_b", [](Person& o, double x) { o.semi_axis_b(x); }},
      {"angle", [](Person& o, double x) { o.angle(x); }},
      {"velocity.x", [](Person& o, double x) { o.velocity().x(x); }},
      {"velocity.y", [](Person& o, double x) { o.velocity().y(x); }}};
  tandem_msgs::msg::ObstacleArray list;
  people_beat_ = node_.create_wall_timer(0.02, [&] { people_.publish(list); });
  for (const auto& [name, number] : numbers)
    for (const double value : kNotFinite) {
      SCOPED_TRACE(name);
      list = to_msg(somebody(5.0), header({}, "map"));
      ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
      number(list.obstacles()[0], value);
      ASSERT_TRUE(wait_until([&] { return v_ == 0.0 && reason_ == Reason::kPeopleSilent; }));
    }
  people_beat_ = {};
}

TEST_F(FilterOverDds, KeepsTheOldMapWhenTheNewOneIsBroken) {
  send_map(encode_octomap(*load_octomap(source_path("maps/yard.bt"))));
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  send_map(std::vector<std::int8_t>(1000, 0x55));
  v_ = -1.0;
  EXPECT_TRUE(wait_until([&] { return v_ == 0.3; }));
}

TEST_F(FilterOverDds, StopsForACommandThatIsNotANumberAndForLostOdometry) {
  send_map(encode_octomap(*load_octomap(source_path("maps/yard.bt"))));
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  push_v_ = kNaN;
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0; }));
  push_v_ = 0.3;
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  beat_ = node_.create_wall_timer(0.02, [this] { command_.publish(to_msg(Twist2{0.3, 0.0})); });
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0; }));
}

// However often it looks between commands: here each command comes after the wrong one of the two.
TEST_F(FilterOverDds, StandsWhileTwoPublishersGiveDifferentPoses) {
  send_map(encode_octomap(*load_octomap(source_path("maps/yard.bt"))));
  ASSERT_TRUE(wait_until([&] { return v_ == 0.3; }));
  other_ = Pose2{0.0, 0.5, 0.0};
  ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kPoseJumped; }));
  reports_.clear();
  ASSERT_TRUE(wait_until([&] { return reports_[Reason::kPoseJumped] > 100; }));
  EXPECT_EQ(reports_.size(), 1U);
  EXPECT_EQ(v_, 0.0);
  other_.reset();
  EXPECT_TRUE(wait_until([&] { return v_ == 0.3; }));
}

TEST_F(OneComponent, ARobotNeverRunsWithoutItsFilterEnforcing) {
  EXPECT_THROW(
      (void)rt::load_component("safety_filter", options("safety_filter", {{"enforce", "false"}})),
      std::invalid_argument);
}

TEST_F(OneComponent, AFilterReportsAnotherPublisherOfCmdVel) {
  const auto filter = load("safety_filter", {{"map_is_odom", "true"}});
  std::string said;
  const auto diagnostics = node_.create_subscription(topics::diagnostics, [&](const auto& msg) {
    for (const auto& status : msg.status()) said = status.message();
  });
  ASSERT_TRUE(wait_until([&] { return !said.empty(); }));
  EXPECT_EQ(said.find("others publish cmd_vel"), std::string::npos);
  auto other = node_.create_publisher(topics::cmd_vel);
  EXPECT_TRUE(wait_until([&] { return said == "others publish cmd_vel, past this filter"; }));
  other = {};
  EXPECT_TRUE(wait_until([&] { return said.find("others publish") == std::string::npos; }));
}

}  // namespace
}  // namespace tandem::test
