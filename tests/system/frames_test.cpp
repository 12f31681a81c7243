// SPDX-License-Identifier: Apache-2.0
// Tests how the nodes handle the frame in a message's header.
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/point_cloud.hpp"
#include "system/one_component.hpp"
#include "system/wall_map.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/model/frame_tree.hpp"

namespace tandem::test {
namespace {

const Pose2 kOdomInMap{3.0, -2.0, 0.7};

using Transforms = std::vector<geometry_msgs::msg::TransformStamped>;

tf2_msgs::msg::TFMessage message_of(const Transforms& transforms) {
  tf2_msgs::msg::TFMessage msg;
  msg.transforms(transforms);
  return msg;
}

geometry_msgs::msg::TransformStamped link(const std::string& parent, const std::string& child,
                                          const Pose2& X) {
  return to_transform(X, header({}, parent), child);
}

// A node that needs the robot's pose, with a localiser and odometry that the test controls.
class FramesOverDds : public OneComponent {
 protected:
  explicit FramesOverDds(const std::string& component = "safety_filter", const Values& values = {})
      : component_{load(component, values)} {
    status_in_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
      reason_ = msg.reason();
      code_ = from_msg(msg.reason_code());
      clearance_ = msg.clearance();
    });
    beat_ = node_.create_wall_timer(kBeat, [this] { beat(); });
  }

  void beat() {
    if (part_at_) tf_links_.back() = part_at_(node_.steady_now());
    if (!tf_links_.empty()) tf_.publish(message_of(tf_links_));
    odom_.publish(to_msg(Odometry{}, header({}, odom_frame_), child_));
    command_.publish(to_msg(Twist2{0.3, 0.0}));
  }
  [[nodiscard]] bool wait_for_reason(const std::string& part) {
    return wait_until([&] { return reason_.find(part) != std::string::npos; });
  }
  [[nodiscard]] bool wait_for_reason(Reason reason) {
    return wait_until([&] { return code_ == reason; });
  }

  CapturedLog log_;
  rt::RunningComponent component_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_ = node_.create_publisher(topics::tf);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_static_ = node_.create_publisher(topics::tf_static);
  rt::Publisher<geometry_msgs::msg::Twist> command_ =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  rt::Publisher<octomap_msgs::msg::Octomap> map_ = node_.create_publisher(topics::octomap_binary);
  rt::Subscription status_in_;
  rt::Timer beat_;
  Transforms tf_links_ = {link("map", "odom", kOdomInMap)};
  // Link of a part that moves on the robot, at a time [s]; replaces the last of tf_links_.
  std::function<geometry_msgs::msg::TransformStamped(double)> part_at_;
  std::string odom_frame_ = "odom", child_ = "base_link";
  std::string reason_;
  Reason code_ = Reason::kNone;
  double clearance_ = kNaN;
};

TEST_F(FramesOverDds, AMapInOdomStandsWhereOdomIs) {
  map_.publish(wall("odom"));
  // The outline's front is 0.51 m ahead; the grid is turned, and grown by 0.03 m.
  ASSERT_TRUE(wait_until([&] { return clearance_ > 0.2 && clearance_ < 0.41; })) << reason_;
  tf_links_ = {link("map", "odom", {3.4, -1.5, 0.7})};  // the localiser corrects itself
  clearance_ = kNaN;
  ASSERT_TRUE(wait_until([&] { return clearance_ > 0.2 && clearance_ < 0.41; })) << reason_;
  tf_links_ = {link("map", "odom", {3.4, -1.5, -2.0})};
  clearance_ = kNaN;
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.2 && clearance_ < 0.41; })) << reason_;
}

TEST_F(FramesOverDds, AMapInAFrameThatIsShiftedForEverIsShiftedToTheBit) {
  tf_links_ = {link("map", "odom", {1.0, 0.0, 0.0})};
  tf_static_.publish(message_of({link("map", "building", {1.0, 0.0, 0.0})}));
  map_.publish(wall("/building"));
  ASSERT_TRUE(wait_until([&] { return clearance_ > 0.2; })) << reason_;
  const double there = clearance_;
  map_.publish(wall("map"));
  EXPECT_TRUE(wait_until([&] { return clearance_ == 0.0; })) << "1 m behind it in map";
  EXPECT_NEAR(there, kWall - 0.51, 0.08);
}

TEST_F(FramesOverDds, AMapInAnUnknownFrameIsRefusedUntilTfProvidesIt) {
  map_.publish(wall("cellar"));
  ASSERT_TRUE(
      wait_for_reason("octomap_binary is given in frame `cellar`, not `map`: not used: "
                      "`cellar` is not on /tf; frames there: "))
      << reason_;
  tf_static_.publish(message_of({link("odom", "cellar", {})}));
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.2; })) << reason_;
}

TEST_F(FramesOverDds, ReportsTheKnownFramesWhenNotLocalised) {
  map_.publish(wall("map"));
  tf_links_ = {link("map", "odom_combined", {})};
  EXPECT_TRUE(
      wait_for_reason("not localized: `odom` is not on /tf; frames there: map → odom_combined"))
      << reason_;
  tf_links_.push_back(link("odom", "wheel", {}));
  EXPECT_TRUE(
      wait_for_reason("no transform on /tf connects `map` and `odom`: map → odom_combined, "
                      "odom → wheel"))
      << reason_;
}

TEST_F(FramesOverDds, MapAndOdomAreJoinedByTheRulesOfTf2) {
  map_.publish(wall("odom"));
  const auto is_placed = [&] {
    clearance_ = kNaN;
    return wait_until([&] { return clearance_ > 0.2 && clearance_ < 0.41; });
  };
  tf_links_ = {link("/map", "/odom", kOdomInMap)};
  EXPECT_TRUE(is_placed()) << reason_;
  tf_links_ = {link("map", "odom_combined", kOdomInMap), link("odom_combined", "odom", {})};
  EXPECT_TRUE(is_placed()) << reason_;
}

TEST_F(FramesOverDds, TheInverseTransformLocalisesToo) {
  tf_links_ = {link("odom", "map", inverse(kOdomInMap))};
  map_.publish(wall("odom"));
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.2 && clearance_ < 0.41; })) << reason_;
}

TEST_F(FramesOverDds, OdometryInAnotherFrameAndOfAnotherPartOfTheRobotIsTransformed) {
  map_.publish(wall("odom"));
  tf_links_ = {link("map", "odom", kOdomInMap), link("odom", "odom_combined", {0.5, 0.0, 0.0})};
  odom_frame_ = "/odom_combined";
  child_ = "base_footprint";
  EXPECT_TRUE(wait_for_reason("not localized: odom is for frame `base_footprint`")) << reason_;
  tf_static_.publish(message_of({link("base_footprint", "base_link", {-0.3, 0.0, 0.0})}));
  // 0.5 m on by the frame, 0.3 m back on the robot.
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.0 && clearance_ < 0.21; })) << reason_;
  odom_frame_ = "world";
  EXPECT_TRUE(wait_for_reason("not localized: odom is given in frame `world`, not `odom`"));
  EXPECT_EQ(code_, Reason::kOtherFrame);
}

// A camera on a turret gives odometry of itself: its twist is not the robot's.
TEST_F(FramesOverDds, OdometryOfAPartThatMovesOnTheRobotIsRefusedUntilThePartIsAtRest) {
  map_.publish(wall("odom"));
  tf_links_.push_back(link("base_link", "turret", {}));
  child_ = "turret";
  ASSERT_TRUE(wait_until([&] { return clearance_ > 0.2; })) << reason_;
  const double began = node_.steady_now();
  double angle = 0.0;
  part_at_ = [&](double t) {
    angle = 0.5 * std::sin(2.0 * (t - began));
    return link("base_link", "turret", {0.0, 0.0, angle});
  };
  EXPECT_TRUE(wait_for_reason(
      "not localized: odom is for frame `turret`, which moves relative to `base_link`"))
      << reason_;
  part_at_ = [&](double) { return link("base_link", "turret", {0.0, 0.0, angle}); };
  clearance_ = kNaN;
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.0; })) << reason_;
}

// Longer than the time over which motion is looked for.
TEST_F(FramesOverDds, OdometryBelowABodyThatSwaysIsTaken) {
  map_.publish(wall("odom"));
  tf_links_.push_back(link("base_footprint", "base_link", {}));
  child_ = "base_footprint";
  const double began = node_.steady_now();
  part_at_ = [&](double t) {
    const double sway = std::sin(10.0 * (t - began));
    auto swaying = link("base_footprint", "base_link", {0.003 * sway, -0.003 * sway, 0.01 * sway});
    swaying.header().stamp(node_.stamp());
    swaying.transform().translation().z(0.3 + 0.02 * sway);
    swaying.transform().rotation().y(0.1 * sway);  // pitch of 0.2 rad
    swaying.transform().rotation().w(std::sqrt(1.0 - 0.01 * sway * sway));
    return swaying;
  };
  ASSERT_TRUE(wait_until([&] { return clearance_ > 0.2; })) << reason_;
  int looks = 0;
  const auto looked =
      node_.create_subscription(topics::filter_status, [&](const auto&) { ++looks; });
  const double until = node_.steady_now() + 1.5 * FrameTree::kMotionWindow;
  EXPECT_TRUE(wait_until([&] { return looks > 20 && node_.steady_now() > until; }));
  EXPECT_EQ(log_.lines("which moves relative to"), 0);
  EXPECT_TRUE(wait_until([&] { return clearance_ > 0.2; })) << reason_;
}

TEST_F(FramesOverDds, AFrameWithTwoParentsIsReportedWithBothPublishers) {
  rt::Node wheels{"wheels"}, filter{"kalman"};
  const auto first = wheels.create_publisher(topics::tf);
  const auto second = filter.create_publisher(topics::tf);
  const auto beat = node_.create_wall_timer(kBeat, [&] {
    first.publish(message_of({link("odom", "base_link", {})}));
    second.publish(message_of({link("odom_combined", "base_link", {})}));
  });
  const auto both = std::string{"frame `base_link` has two parents on /tf: "};
  EXPECT_TRUE(wait_until([&] {
    return log_.lines(both + "`odom` by /wheels, `odom_combined` by /kalman") +
               log_.lines(both + "`odom_combined` by /kalman, `odom` by /wheels") >
           0;
  }));
}

class PeopleInFrames : public FramesOverDds {
 protected:
  PeopleInFrames() : FramesOverDds{"safety_filter", {{"people", "true"}}} {}
};

TEST_F(PeopleInFrames, PeopleAreWhereTheirFrameSays) {
  octomap_msgs::msg::Octomap hall = wall("odom");
  octomap::OcTree tree(0.05);
  tree.updateNode(9.0, 9.0, 0.3, true);
  hall.data(encode_octomap(tree));
  map_.publish(hall);
  std::string frame = "odom";
  const auto people = node_.create_publisher(topics::people);
  const auto list = node_.create_wall_timer(kBeat, [&] {
    people.publish(to_msg(std::vector<Obstacle>{{.p_MO = {0.85, 0.0}, .a = 0.25, .b = 0.25}},
                          header({}, frame)));
  });
  EXPECT_TRUE(wait_for_reason(Reason::kSlowed)) << reason_;
  frame = "map";
  EXPECT_TRUE(wait_for_reason(Reason::kClear)) << reason_;
  frame = "";
  EXPECT_TRUE(wait_for_reason(Reason::kPeopleSilent)) << reason_;
}

class PlannerInFrames : public FramesOverDds {
 protected:
  PlannerInFrames()
      : FramesOverDds{"local_planner",
                      {{"method", "goal"}, {"odom_timeout", "0.4"}, {"obstacle_timeout", "0.4"}}} {}
};

TEST_F(PlannerInFrames, AGoalInOdomIsWhereOdomIs) {
  const auto obstacles = node_.create_publisher(topics::obstacles);
  const auto goal = node_.create_publisher(topics::goal_pose);
  std::optional<Pose2> end;
  const auto plan = node_.create_subscription(topics::plan, [&](const auto& msg) {
    if (!msg.poses().empty()) end = from_msg(msg.poses().back().pose());
  });
  const auto beat = node_.create_wall_timer(kBeat, [&] {
    obstacles.publish(to_msg(std::vector<Obstacle>{}, header({}, "map")));
    goal.publish(to_msg(Pose2{1.0, 0.0, 0.0}, header({}, "odom")));
  });
  const Eigen::Vector2d ahead{std::cos(kOdomInMap.theta), std::sin(kOdomInMap.theta)};
  EXPECT_TRUE(wait_until([&] {
    return end && (end->position() - kOdomInMap.position()).dot(ahead) > 0.3 &&
           std::abs(end->theta - kOdomInMap.theta) < 0.2;
  }));
}

class BuilderInFrames : public FramesOverDds {
 protected:
  BuilderInFrames() : FramesOverDds{"octomap_builder", {{"map_is_odom", "true"}}} {
    maps_in_ = node_.create_subscription(topics::octomap_local, [this](const auto& msg) {
      const auto decoded =
          decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), true);
      if (decoded.tree) tree_ = std::make_unique<octomap::OcTree>(*decoded.tree);
    });
    odometry_ = node_.create_wall_timer(kBeat, [this] {
      odom_.publish(to_msg(Odometry{}, header(node_.stamp(), "odom"), "base_link"));
      sensor_msgs::msg::LaserScan scan;
      scan.header(header(node_.stamp(), sensor_));
      scan.angle_increment(1.0F);
      scan.range_max(10.0F);
      scan.ranges(
          {2.02F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()});
      scan_.publish(scan);
    });
    beat_ = node_.create_wall_timer(kBeat, [this] { tf_.publish(message_of(tf_links_)); });
    // A turret, looking back.
    tf_links_ = {link("base_link", "mast", {-0.5, 0.0, 0.0}),
                 link("mast", "laser", {0.0, 0.0, std::numbers::pi})};
  }
  [[nodiscard]] bool is_occupied(double x, double y) const {
    const auto* voxel = tree_ ? tree_->search(x, y, 0.02) : nullptr;
    return voxel != nullptr && tree_->isNodeOccupied(voxel);
  }

  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ = node_.create_publisher(topics::scan);
  rt::Subscription maps_in_;
  rt::Timer odometry_;
  std::unique_ptr<octomap::OcTree> tree_;
  std::string sensor_ = "laser";
};

TEST_F(BuilderInFrames, ASensorMountedByATfTransformIsPlaced) {
  EXPECT_TRUE(wait_until([&] { return is_occupied(-2.52, 0.0); }));
  EXPECT_FALSE(is_occupied(1.52, 0.0));
}

// If such a scan were accepted, its beams would start at the map's origin and clear everything in
// between.
TEST_F(BuilderInFrames, AScanInAFrameThatTheRobotMovesInIsRefused) {
  for (const char* frame : {"map", "/odom", "odom_combined"}) {
    sensor_ = frame;
    tf_links_ = {link("odom_combined", "base_link", {})};
    EXPECT_TRUE(wait_until([&] {
      return log_.lines("scan dropped: it is given in frame `" + sensor_ +
                        "`, which does not move with the robot") > 0;
    })) << frame;
  }
  EXPECT_FALSE(tree_);
}

// `tandem doctor` next to a robot that is not localised.
TEST_F(FramesOverDds, TheDoctorListsTheFramesThatThereAre) {
  map_.publish(wall("map"));
  tf_links_ = {link("map", "odom_combined", {})};
  ASSERT_TRUE(wait_for_reason(Reason::kNotLocalized));
  char file[] = "/tmp/tandem_doctor_XXXXXX";
  close(mkstemp(file));
  ChildProcess doctor{"/bin/sh", {"-c", binary_path("tandem") + " doctor --wait 2 > " + file}};
  std::optional<int> status;
  ASSERT_TRUE(spin_until([&] { return (status = doctor.wait(0.0)).has_value(); }, 60.0, node_));
  std::ifstream stream{file};
  const std::string said{std::istreambuf_iterator<char>{stream}, {}};
  std::remove(file);
  EXPECT_EQ(status, 1);
  EXPECT_NE(said.find("map → odom_combined"), std::string::npos) << said;
  EXPECT_NE(said.find("/tester"), std::string::npos) << said;
  const std::string reason = "not localized: `odom` is not on /tf";
  const auto found = said.find("the safety filter stops the robot: " + reason);
  EXPECT_NE(found, std::string::npos) << said;
  EXPECT_EQ(said.find(reason), said.rfind(reason)) << "once: " << said;
}

}  // namespace
}  // namespace tandem::test
