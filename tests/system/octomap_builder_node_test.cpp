// SPDX-License-Identifier: Apache-2.0
#include <numbers>
#include <random>

#include "map/octomap_file.hpp"
#include "support/captured_log.hpp"
#include "support/instrumented.hpp"
#include "support/point_cloud.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kBeamTurn = 2.0 * std::numbers::pi / 360;
constexpr unsigned kNoise = samples(100'000, 10'000);  // points

// A robot at (2.013, 1.017), turned to the left, in a round room of 3 m; no echo is near the border
// of a voxel.
const Pose2 kRobot{2.013, 1.017, std::numbers::pi / 2.0};

class BuilderOverDds : public OneComponent {
 protected:
  BuilderOverDds() {
    maps_in_ = node_.create_subscription(topics::octomap_local, [this](const auto& msg) {
      const auto decoded =
          decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), true);
      ASSERT_TRUE(decoded.tree) << decoded.error;
      tree_ = std::make_unique<octomap::OcTree>(*decoded.tree);
      frame_ = msg.header().frame_id();
      ++maps_;
    });
    publish_frame("base_link", "base_scan", Eigen::Isometry3d{Eigen::Translation3d(0, 0, 0.3)});
    odometry_ = node_.create_wall_timer(0.02, [this] {
      odom_.publish(to_msg(Odometry{kRobot, {}}, header(node_.stamp(), "odom"), "base_link"));
    });
  }

  void publish_frame(const std::string& parent, const std::string& child,
                     const Eigen::Isometry3d& X_PC) {
    tf2_msgs::msg::TFMessage msg;
    msg.transforms().push_back(to_transform(X_PC, header(node_.stamp(), parent), child));
    tf_static_.publish(msg);
  }
  [[nodiscard]] sensor_msgs::msg::LaserScan scan(float range) const {
    sensor_msgs::msg::LaserScan msg;
    msg.header(header(node_.stamp(), "base_scan"));
    msg.angle_increment(static_cast<float>(kBeamTurn));
    msg.range_max(10.0F);
    msg.ranges().assign(360, range);
    return msg;
  }
  [[nodiscard]] bool wait_for_maps(long more) {
    const long before = maps_;
    const auto beat = node_.create_wall_timer(0.05, [this] { scan_.publish(scan(3.0F)); });
    return wait_until([&] { return maps_ >= before + more; });
  }
  [[nodiscard]] bool is_occupied(double x, double y) const {
    const auto* voxel = tree_->search(x, y, 0.3);
    return voxel != nullptr && tree_->isNodeOccupied(voxel);
  }

  CapturedLog log_;
  rt::RunningComponent builder_ = load("octomap_builder", {{"map_is_odom", "true"}});
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ = node_.create_publisher(topics::scan);
  rt::Publisher<sensor_msgs::msg::PointCloud2> cloud_ = node_.create_publisher(topics::cloud_in);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_static_ = node_.create_publisher(topics::tf_static);
  rt::Subscription maps_in_;
  rt::Timer odometry_;
  std::unique_ptr<octomap::OcTree> tree_;
  std::string frame_;
  long maps_ = 0;
};

TEST_F(BuilderOverDds, ShowsWhatAScanSeesWhereTheRobotIs) {
  ASSERT_TRUE(wait_for_maps(2));
  EXPECT_EQ(frame_, "map");
  for (int i = 0; i < 12; ++i) {
    const double angle = kBeamTurn * 30.0 * i;
    EXPECT_TRUE(is_occupied(kRobot.x + 3.001 * std::cos(angle), kRobot.y + 3.001 * std::sin(angle)))
        << i;
    EXPECT_FALSE(is_occupied(kRobot.x + 2.5 * std::cos(angle), kRobot.y + 2.5 * std::sin(angle)))
        << i;
  }
}

TEST_F(BuilderOverDds, IsSilentWithoutScans) {
  ASSERT_TRUE(wait_for_maps(1));
  // One may be under way yet.
  const double until = node_.steady_now() + 0.5;
  long heard = 0;
  ASSERT_TRUE(wait_until([&] {
    if (node_.steady_now() < until - 0.3) heard = maps_;
    return node_.steady_now() > until;
  }));
  EXPECT_EQ(maps_, heard);
}

TEST_F(BuilderOverDds, MalformedScansAndCloudsAreRefusedWithOneLineAndNothingIsLost) {
  ASSERT_TRUE(wait_for_maps(1));
  auto bad_scan = scan(1.0F);
  bad_scan.angle_increment(static_cast<float>(kNaN));
  sensor_msgs::msg::PointCloud2 bad_cloud;
  bad_cloud.header(header(node_.stamp(), "base_link"));
  bad_cloud.width(1000);
  bad_cloud.height(1);
  const auto beat = node_.create_wall_timer(0.02, [&] {
    scan_.publish(bad_scan);
    cloud_.publish(bad_cloud);
  });
  ASSERT_TRUE(wait_until([&] {
    return log_.lines("scan refused: angle_min and angle_increment must be finite") > 0 &&
           log_.lines("cloud_in refused: no field `x`") > 0;
  }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
  EXPECT_FALSE(is_occupied(kRobot.x + 1.001, kRobot.y));
}

// A laser that looks backward from a mast, of which /tf_static tells in two messages, late.
TEST_F(BuilderOverDds, WhereASensorSitsIsWhatTfStaticSaysOfItsFrame) {
  auto ahead = scan(std::numeric_limits<float>::infinity());
  ahead.header().frame_id("laser");
  ahead.ranges()[0] = 2.001F;
  const auto beat = node_.create_wall_timer(0.05, [&] {
    ahead.header().stamp(node_.stamp());
    scan_.publish(ahead);
  });
  ASSERT_TRUE(wait_until([&] {
    return log_.lines(
               "scan dropped: /tf_static does not say where its frame `laser` is on "
               "`base_link`") > 0;
  }));
  EXPECT_EQ(maps_, 0);
  publish_frame("base_link", "mast", Eigen::Isometry3d{Eigen::Translation3d(-0.5, 0.0, 0.0)});
  publish_frame("mast", "laser",
                Eigen::Translation3d(0.0, 0.0, 0.3) *
                    Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  ASSERT_TRUE(wait_until([&] { return maps_ > 0; }));
  EXPECT_TRUE(is_occupied(kRobot.x, kRobot.y - 2.501));
  EXPECT_FALSE(is_occupied(kRobot.x, kRobot.y + 2.001));
}

TEST_F(BuilderOverDds, AFrameThatIsNotFiniteIsRefused) {
  Eigen::Isometry3d nowhere = Eigen::Isometry3d::Identity();
  nowhere.translation().x() = kNaN;
  publish_frame("base_link", "base_scan", nowhere);
  ASSERT_TRUE(wait_until(
      [&] { return log_.lines("/tf_static of `base_scan` is not finite: dropped") > 0; }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
}

// Points all over the window, as a camera gone mad tells them: it costs some moments, no more.
TEST_F(BuilderOverDds, ACloudOfNoiseIsSurvived) {
  ASSERT_TRUE(wait_for_maps(1));
  std::mt19937 random{1};
  std::uniform_real_distribution<float> wide(-5.0F, 5.0F), high(-0.6F, 1.0F);
  std::vector<Eigen::Vector3f> points;
  for (unsigned i = 0; i < kNoise; ++i)
    points.emplace_back(wide(random), wide(random), high(random));
  cloud_.publish(cloud_of(points, header(node_.stamp(), "base_scan")));
  ASSERT_TRUE(wait_until([&] {
    return is_occupied(kRobot.x + 1.0, kRobot.y + 1.0) || tree_->getNumLeafNodes() > 50'000;
  }));
  EXPECT_TRUE(wait_for_maps(5));
}

TEST_F(BuilderOverDds, ResetForgetsAllThatWasSeen) {
  ASSERT_TRUE(wait_for_maps(1));
  ASSERT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
  const auto client =
      node_.create_client(rt::ServiceName<std_srvs::srv::Trigger>{"/octomap_builder/reset"});
  bool answered = false;
  client.call({}, [&](const auto& response) { answered = response.success(); });
  ASSERT_TRUE(wait_until([&] { return answered; }));
  const auto beat = node_.create_wall_timer(0.05, [this] { scan_.publish(scan(2.0F)); });
  EXPECT_TRUE(wait_until([&] {
    return is_occupied(kRobot.x + 2.001, kRobot.y) && !is_occupied(kRobot.x + 3.001, kRobot.y);
  }));
}

TEST_F(BuilderOverDds, AScanOfATimeWithoutOdometryIsDropped) {
  ASSERT_TRUE(wait_for_maps(1));
  auto old = scan(1.0F);
  old.header().stamp().sec(old.header().stamp().sec() - 100);
  const auto beat = node_.create_wall_timer(0.02, [&] { scan_.publish(old); });
  ASSERT_TRUE(wait_until([&] { return log_.lines("scan dropped: no odometry of its time") > 0; }));
  ASSERT_TRUE(wait_for_maps(1));
  EXPECT_FALSE(is_occupied(kRobot.x + 1.001, kRobot.y));
}

TEST_F(OneComponent, AFilterWithLiveSensingStandsUntilSomethingIsSeenAndWhenNothingIsAnyMore) {
  const auto filter = load("safety_filter", {{"map_is_odom", "true"}, {"map_source", "local"}});
  double v = -1.0;
  std::string reason;
  const auto out =
      node_.create_subscription(topics::cmd_vel, [&](const auto& msg) { v = msg.linear().x(); });
  const auto status = node_.create_subscription(topics::filter_status,
                                                [&](const auto& msg) { reason = msg.reason(); });
  const auto odom = node_.create_publisher(topics::odom);
  const auto command = node_.create_publisher(topics::cmd_vel_arbitrated);
  const auto map = node_.create_publisher(topics::octomap_local);
  const auto beat = node_.create_wall_timer(0.02, [&] {
    odom.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
    command.publish(to_msg(Twist2{0.3, 0.0}));
  });
  ASSERT_TRUE(wait_until([&] { return v == 0.0 && reason == "no map yet"; }));

  octomap_msgs::msg::Octomap msg;
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(0.05);
  octomap::OcTree tree(0.05);
  tree.updateNode(octomap::point3d(0.0F, 0.0F, 0.3F), false);
  msg.data(encode_octomap(tree));  // nothing stands there, and that is no error
  auto looks = node_.create_wall_timer(0.1, [&] { map.publish(msg); });
  ASSERT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));

  for (int i = -20; i <= 20; ++i)
    tree.updateNode(octomap::point3d(0.57F, 0.05F * static_cast<float>(i), 0.3F), true);
  msg.data(encode_octomap(tree));
  ASSERT_TRUE(wait_until([&] { return v < 0.3 && reason != "clear"; }));
  looks = {};
  EXPECT_TRUE(wait_until([&] { return v == 0.0 && reason == "octomap_local is silent"; }));
}

}  // namespace
}  // namespace tandem::test
