// SPDX-License-Identifier: Apache-2.0
#include <octomap/ColorOcTree.h>

#include <algorithm>
#include <sstream>

#include "support/captured_log.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/runtime/local_bus.hpp"

namespace tandem::test {
namespace {

const Pose2 kStartPose{-3.0, -3.0, 0.0};
const Eigen::Vector2d kPole{-2.0, -2.0}, kFarPole{3.0, 4.0};  // of the forest

nav_msgs::msg::Odometry odometry(const Pose2& X) {
  return to_msg(Odometry{X, {}}, header({}, "odom"), "base_link");
}

octomap_msgs::msg::Octomap octomap(std::vector<std::int8_t> data) {
  octomap_msgs::msg::Octomap msg;
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(0.05);
  msg.data(std::move(data));
  return msg;
}

bool covers(const std::vector<Obstacle>& list, const Eigen::Vector2d& p_MQ) {
  return std::any_of(list.begin(), list.end(),
                     [&](const Obstacle& obstacle) { return contains(obstacle, p_MQ); });
}

class ExtractorOverDds : public OneComponent {
 protected:
  explicit ExtractorOverDds(const std::string& people = "false",
                            const std::string& map_source = "static")
      : extractor_{
            load("obstacle_extractor",
                 {{"map_is_odom", "true"}, {"people", people}, {"map_source", map_source}})} {
    lists_in_ = node_.create_subscription(topics::obstacles, [this](const auto& msg) {
      seen_ = from_msg(msg).all;
      frame_ = msg.header().frame_id();
      ++lists_;
    });
    start_odometry();
  }

  void start_odometry() {
    beat_ = node_.create_wall_timer(0.02, [this] { odom_.publish(odometry_); });
  }
  static octomap_msgs::msg::Octomap forest() {
    return octomap(encode_octomap(*load_octomap(source_path("maps/forest.bt"))));
  }
  [[nodiscard]] bool covered(const Eigen::Vector2d& p_MQ) const { return covers(seen_, p_MQ); }
  [[nodiscard]] bool wait_for_lists(long more) {
    const long before = lists_;
    return wait_until([&] { return lists_ >= before + more; });
  }

  CapturedLog log_;
  rt::RunningComponent extractor_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<octomap_msgs::msg::Octomap> map_ = node_.create_publisher(topics::octomap_binary);
  rt::Subscription lists_in_;
  rt::Timer beat_;
  nav_msgs::msg::Odometry odometry_ = odometry(kStartPose);

  std::vector<Obstacle> seen_;
  std::string frame_;
  long lists_ = 0;
};

TEST_F(ExtractorOverDds, ListsTheMapsObstaclesNearTheRobot) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  EXPECT_EQ(frame_, "map");
  EXPECT_TRUE(covered(kPole));
  EXPECT_FALSE(covered(kStartPose.position()));
  EXPECT_FALSE(covered(kFarPole));
  odometry_ = odometry({2.0, 3.0, 0.0});
  EXPECT_TRUE(wait_until([&] { return covered(kFarPole); }));
}

class ExtractorAmongPeople : public ExtractorOverDds {
 protected:
  ExtractorAmongPeople() : ExtractorOverDds{"true"} {
    people_beat_ = node_.create_wall_timer(0.02, [this] {
      if (talks_) people_.publish(to_msg(walkers_, header({}, "map")));
    });
  }

  const std::vector<Obstacle> walkers_{
      {.id = 7, .p_MO = {-2.6, -3.4}, .a = 0.25, .b = 0.25, .v_MO = {0.5, -0.2}}};
  rt::Publisher<tandem_msgs::msg::ObstacleArray> people_ = node_.create_publisher(topics::people);
  rt::Timer people_beat_;
  bool talks_ = true;
};

TEST_F(ExtractorAmongPeople, ListsThemWithTheirVelocityAndNothingWhileTheyAreSilent) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  EXPECT_TRUE(covered(kPole));
  EXPECT_EQ(seen_.back().p_MO, walkers_[0].p_MO);
  EXPECT_EQ(seen_.back().v_MO, walkers_[0].v_MO);
  EXPECT_TRUE(seen_.back().tracked);
  EXPECT_FALSE(seen_.front().tracked) << "it is a wall or a pole";
  talks_ = false;
  EXPECT_TRUE(wait_until([&] { return log_.lines("no obstacles: people are silent") > 0; }));
  talks_ = true;
  EXPECT_TRUE(wait_for_lists(1));
}

TEST_F(ExtractorOverDds, DrawsWhatItLists) {
  std::size_t drawn = 0;
  const auto markers = node_.create_subscription(
      topics::obstacle_markers, [&](const auto& msg) { drawn = msg.markers().size(); });
  map_.publish(forest());
  ASSERT_TRUE(wait_until([&] { return drawn > 0 && lists_ > 0; }));
  EXPECT_EQ(drawn, seen_.size() + 1);  // one deletes the old ones
}

TEST_F(ExtractorOverDds, TakesTheColoredTreeThatRtabMapSends) {
  const auto plain = load_octomap(source_path("maps/forest.bt"));
  octomap::ColorOcTree colored(plain->getResolution());
  for (auto leaf = plain->begin_leafs_bbx(octomap::point3d(-4, -4, 0), octomap::point3d(0, 0, 1));
       leaf != plain->end_leafs_bbx(); ++leaf)
    colored.setNodeValue(leaf.getKey(), leaf->getLogOdds());
  std::ostringstream bytes;
  colored.writeData(bytes);
  const std::string data = bytes.str();
  auto msg = octomap({data.begin(), data.end()});
  msg.id("ColorOcTree");
  msg.binary(false);
  map_.publish(msg);
  ASSERT_TRUE(wait_for_lists(1));
  EXPECT_TRUE(covered(kPole));
}

TEST_F(ExtractorOverDds, KeepsItsMapWhenASecondRobotPublishesAnother) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  const auto hall = octomap(encode_octomap(*load_octomap(source_path("maps/hall.bt"))));
  {
    const auto other = node_.create_publisher(topics::octomap_binary);
    ASSERT_TRUE(wait_until([&] { return other.matched() == 1; }));
    other.publish(hall);
    ASSERT_TRUE(
        wait_until([&] { return log_.lines("octomap_binary refused: 2 nodes publish it") == 1; }));
    ASSERT_TRUE(wait_for_lists(15));
    EXPECT_TRUE(covered(kPole));
  }
  ASSERT_TRUE(wait_for_lists(15));
  EXPECT_TRUE(covered(kPole)) << "the remaining one publishes the same as before";

  // As a map_server that is brought back while DDS still believes in the one that died.
  const auto next = node_.create_publisher(topics::octomap_binary);
  ASSERT_TRUE(wait_until([&] { return next.matched() == 1; }));
  next.publish(hall);
  ASSERT_TRUE(wait_for_lists(15));
  EXPECT_TRUE(covered(kPole));
  map_ = {};
  EXPECT_TRUE(wait_until([&] { return !covered(kPole); })) << "one refusal is not permanent";
}

TEST_F(ExtractorOverDds, AcceptsTheMapOfARestartedMapServer) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  map_ = {};
  const auto next = node_.create_publisher(topics::octomap_binary);
  ASSERT_TRUE(wait_until([&] { return next.matched() == 1; }));
  next.publish(octomap(encode_octomap(*load_octomap(source_path("maps/hall.bt")))));
  EXPECT_TRUE(wait_until([&] { return !covered(kPole); }));
}

TEST_F(ExtractorOverDds, IsSilentWithoutAMap) {
  EXPECT_TRUE(wait_until([&] { return log_.lines("no obstacles: no map yet") > 0; }));
  EXPECT_EQ(lists_, 0);
}

struct Damage {
  const char* name;
  octomap_msgs::msg::Octomap (*to)(octomap_msgs::msg::Octomap forest);
};

class BrokenMap : public ExtractorOverDds, public ::testing::WithParamInterface<Damage> {};

TEST_P(BrokenMap, IsRefusedWithOneErrorAndTheOldOneStays) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  map_.publish(GetParam().to(forest()));
  ASSERT_TRUE(wait_until([&] { return log_.lines("octomap_binary refused: ") == 1; }));
  ASSERT_TRUE(wait_for_lists(15));  // more than were under way
  EXPECT_EQ(log_.lines("[error]"), 1) << log_.text();
  EXPECT_TRUE(covered(kPole));
}

INSTANTIATE_TEST_SUITE_P(Damages, BrokenMap,
                         ::testing::Values(Damage{"other_type",
                                                  [](auto map) {
                                                    map.id("CountingOcTree");
                                                    map.binary(false);
                                                    return map;
                                                  }},
                                           Damage{"resolution_nan",
                                                  [](auto map) {
                                                    map.resolution(kNaN);
                                                    return map;
                                                  }},
                                           Damage{"cut_off",
                                                  [](auto map) {
                                                    map.data().resize(map.data().size() / 2);
                                                    return map;
                                                  }},
                                           Damage{"empty",
                                                  [](auto map) {
                                                    map.data().clear();
                                                    return map;
                                                  }},
                                           Damage{"noise",
                                                  [](auto map) {
                                                    map.data().assign(1000, 0x55);
                                                    return map;
                                                  }}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_F(ExtractorOverDds, FallsSilentWithOdometry) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  const std::string reason = "no obstacles: not localized";
  const int said = log_.lines(reason);  // on a busy machine the map may have come before odometry
  beat_ = {};
  ASSERT_TRUE(wait_until([&] { return log_.lines(reason) == said + 1; }));
  const long heard = lists_;
  int diagnoses = 0;
  const auto diagnostics = node_.create_subscription(topics::diagnostics, [&](const auto& msg) {
    for (const auto& status : msg.status())
      if (status.message().starts_with("not localized")) ++diagnoses;
  });
  ASSERT_TRUE(wait_until([&] { return diagnoses == 2; }));  // a second later
  EXPECT_LT(lists_, heard + 20);  // those under way; who goes on says 40 in that time
  EXPECT_EQ(log_.lines(reason), said + 1) << "once";
}

TEST_F(ExtractorOverDds, LogsASilenceThatSoonReturns) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  for (int silence = 1; silence <= 3; ++silence) {
    const std::string reason = "no obstacles: not localized";
    const int said = log_.lines(reason);
    beat_ = {};
    EXPECT_TRUE(wait_until([&] { return log_.lines(reason) > said; })) << silence;
    start_odometry();
    ASSERT_TRUE(wait_for_lists(5));  // more than were under way
  }
}

class ExtractorWithoutAFinishedMap : public ExtractorOverDds {
 protected:
  ExtractorWithoutAFinishedMap() : ExtractorOverDds{"false", "local"} {}
  rt::Publisher<octomap_msgs::msg::Octomap> local_ = node_.create_publisher(topics::octomap_local);
};

TEST_F(ExtractorWithoutAFinishedMap, ReportsThatSensingStopped) {
  EXPECT_TRUE(wait_until([&] { return log_.lines("no obstacles: no map yet") > 0; }));
  octomap::OcTree seen{0.05};
  seen.updateNode(kPole.x(), kPole.y(), 0.3, true);
  const auto look = octomap(encode_octomap(seen));
  auto looks = node_.create_wall_timer(0.1, [&] { local_.publish(look); });
  ASSERT_TRUE(wait_until([&] { return covered(kPole); }));
  looks = {};
  EXPECT_TRUE(wait_until([&] { return log_.lines("no obstacles: octomap_local is silent") > 0; }));
}

// On a bus inside the process, whose time does not pass while the shapes are fitted.
TEST(ExtractorOnALocalBus, ListsWhatASensorSeesWithoutWaitingForItsPeriod) {
  const auto bus = std::make_shared<rt::LocalBus>();
  rt::NodeOptions slow = options(
      "obstacle_extractor", {{"map_is_odom", "true"}, {"map_source", "local"}, {"period", "1.0"}});
  slow.bus = bus;
  const auto extractor = rt::load_component("obstacle_extractor", slow);
  rt::Node node{rt::NodeOptions{.name = "test", .bus = bus}};
  const auto odom = node.create_publisher(topics::odom);
  const auto local = node.create_publisher(topics::octomap_local);
  std::vector<Obstacle> list;
  const auto lists = node.create_subscription(topics::obstacles,
                                              [&](const auto& msg) { list = from_msg(msg).all; });
  octomap::OcTree seen{0.05};
  for (const Eigen::Vector2d& p : {kPole, Eigen::Vector2d{-3.0, -1.5}}) {
    odom.publish(odometry(kStartPose));
    seen.updateNode(p.x(), p.y(), 0.3, true);
    local.publish(octomap(encode_octomap(seen)));
    bus->run_for(0.01);
    EXPECT_TRUE(covers(list, p)) << p.transpose();
  }
}

TEST_F(ExtractorOverDds, OdometryThatIsNotANumberIsIgnored) {
  map_.publish(forest());
  ASSERT_TRUE(wait_for_lists(1));
  odometry_ = odometry({kNaN, 0.0, 0.0});
  EXPECT_TRUE(wait_until([&] { return log_.lines("odom is not finite: dropped") > 0; }));
  EXPECT_TRUE(wait_until([&] { return log_.lines("no obstacles: not localized") > 0; }));
}

}  // namespace
}  // namespace tandem::test
