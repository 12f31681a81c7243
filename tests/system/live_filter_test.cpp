// SPDX-License-Identifier: Apache-2.0
// Tests a safety filter that uses only sensor data, without a map.
#include <optional>

#include "system/builder_over_dds.hpp"
#include "tandem/runtime/local_bus.hpp"

namespace tandem::test {
namespace {

void cover_ground(octomap::OcTree& tree) {
  const auto middle = [](int i) { return 0.05F * (static_cast<float>(i) + 0.5F); };
  for (int ix = -40; ix < 40; ++ix)
    for (int iy = -40; iy < 40; ++iy)
      tree.updateNode(octomap::point3d(middle(ix), middle(iy), 0.3F), false);
}

// The filter uses octomap_local; the test takes the role of octomap_builder and the base.
class FilterWithLiveSensing : public OneComponent {
 protected:
  FilterWithLiveSensing() {
    map_.binary(true);
    map_.id("OcTree");
    map_.resolution(0.05);
  }
  void show(const octomap::OcTree& tree) { map_.data(encode_octomap(tree)); }
  [[nodiscard]] bool drives(double v, Reason reason) {
    return wait_until([&] { return v_ == v && reason_ == reason; });
  }

  rt::RunningComponent filter_ =
      load("safety_filter", {{"map_is_odom", "true"}, {"map_source", "local"}});
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Publisher<octomap_msgs::msg::Octomap> maps_ = node_.create_publisher(topics::octomap_local);
  rt::Subscription out_ = node_.create_subscription(
      topics::cmd_vel, [this](const auto& msg) { v_ = msg.linear().x(); });
  rt::Subscription status_ = node_.create_subscription(
      topics::filter_status, [this](const auto& msg) { reason_ = from_msg(msg.reason_code()); });
  rt::Timer beat_ = node_.create_wall_timer(0.02, [this] {
    odom_.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
    command_.publish(to_msg(Twist2{0.3, 0.0}));
  });
  octomap_msgs::msg::Octomap map_;
  octomap::OcTree tree_{0.05};
  double v_ = -1.0;
  Reason reason_ = Reason::kNone;
};

TEST_F(FilterWithLiveSensing, StandsUntilSomethingIsSeenAndWhenNothingIsAnyMore) {
  ASSERT_TRUE(drives(0.0, Reason::kNoMapYet));

  tree_.updateNode(octomap::point3d(0.0F, 0.0F, 0.3F), false);
  show(tree_);  // an empty map is not an error
  auto looks = node_.create_wall_timer(0.1, [&] { maps_.publish(map_); });
  ASSERT_TRUE(drives(0.15, Reason::kUnseenGround));
  cover_ground(tree_);
  show(tree_);
  ASSERT_TRUE(drives(0.3, Reason::kClear));

  for (int i = -20; i <= 20; ++i)
    tree_.updateNode(octomap::point3d(0.57F, 0.05F * static_cast<float>(i), 0.3F), true);
  show(tree_);
  ASSERT_TRUE(wait_until([&] { return v_ < 0.3 && reason_ != Reason::kClear; }));
  looks = {};
  EXPECT_TRUE(drives(0.0, Reason::kLocalMapSilent));
}

// The builder's report on its sensors takes precedence over the age of the map.
TEST_F(FilterWithLiveSensing, StandsWhileTheBuilderSaysThatItsSensorsDoNotSee) {
  cover_ground(tree_);
  show(tree_);
  const auto looks = node_.create_wall_timer(0.02, [&] { maps_.publish(map_); });
  ASSERT_TRUE(drives(0.3, Reason::kClear));  // a foreign map source

  auto sensing = std::optional{node_.create_publisher(topics::sensing_status)};
  tandem_msgs::msg::SensingStatus word;
  auto words = node_.create_wall_timer(0.1, [&] { sensing->publish(word); });
  ASSERT_TRUE(wait_until([&] { return sensing->matched() > 0; }));
  ASSERT_TRUE(drives(0.3, Reason::kClear));
  word.reason("scan gives no valid range");
  ASSERT_TRUE(drives(0.0, Reason::kSensorBlind));
  word.reason("");
  ASSERT_TRUE(drives(0.3, Reason::kClear));
  words = {};
  ASSERT_TRUE(drives(0.0, Reason::kSensingSilent));
  sensing.reset();
  EXPECT_TRUE(drives(0.3, Reason::kClear));
}

// On a bus inside the process, whose time does not pass while the map is read.
TEST(FilterOnALocalBus, BrakesForWhatASensorSeesWithoutWaitingForACommand) {
  const auto bus = std::make_shared<rt::LocalBus>();
  rt::NodeOptions live =
      options("safety_filter", {{"map_is_odom", "true"}, {"map_source", "local"}});
  live.bus = bus;
  const auto filter = rt::load_component("safety_filter", live);
  rt::Node node{rt::NodeOptions{.name = "test", .bus = bus}};
  const auto odom = node.create_publisher(topics::odom);
  const auto command = node.create_publisher(topics::cmd_vel_arbitrated);
  const auto maps = node.create_publisher(topics::octomap_local);
  double v = -1.0;
  const auto out =
      node.create_subscription(topics::cmd_vel, [&](const auto& msg) { v = msg.linear().x(); });
  octomap::OcTree tree{0.05};
  cover_ground(tree);
  octomap_msgs::msg::Octomap map;
  map.binary(true);
  map.id("OcTree");
  map.resolution(0.05);
  const auto show = [&] {
    map.data(encode_octomap(tree));
    maps.publish(map);
    bus->run_for(0.0);
  };
  for (int i = 0; i < 5; ++i) {
    odom.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
    command.publish(to_msg(Twist2{0.3, 0.0}));
    show();
    bus->run_for(0.02);
  }
  ASSERT_EQ(v, 0.3);
  for (int i = -20; i <= 20; ++i)
    tree.updateNode(octomap::point3d(0.57F, 0.05F * static_cast<float>(i), 0.3F), true);
  show();
  EXPECT_LT(v, 0.3);
}

// Two sensors over DDS: if either is lost, the robot stops and reports which.
class FilterBesideABuilder : public BuilderOverDds {
 protected:
  FilterBesideABuilder() {
    status_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
      stands_ = msg.passed().linear().x() == 0.0;
      filters_reason_ = msg.reason();
    });
    push_ = node_.create_wall_timer(0.02, [this] { command_.publish(to_msg(Twist2{0.1, 0.0})); });
  }
  [[nodiscard]] bool stands_for(const std::string& part) const {
    return stands_ && filters_reason_.find(part) != std::string::npos;
  }

  rt::RunningComponent filter_ =
      load("safety_filter", {{"map_is_odom", "true"}, {"map_source", "local"}});
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Subscription status_;
  rt::Timer push_;
  bool stands_ = true;
  std::string filters_reason_;
};

TEST_F(FilterBesideABuilder, StandsForEitherOfTwoSensorsThatIsLost) {
  auto camera = camera_that_sees(true);
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return !stands_; }));
  ASSERT_TRUE(wait_with_scans([](auto& msg) { msg.ranges().assign(360, 0.0F); },
                              [&] { return stands_for("scan gives no valid range"); }));
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return !stands_; }));
  camera = {};
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return stands_for("cloud_in is silent"); }));
}

}  // namespace
}  // namespace tandem::test
