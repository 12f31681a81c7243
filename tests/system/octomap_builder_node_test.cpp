// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
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
  explicit BuilderOverDds(Values parameters = {}) {
    parameters["map_is_odom"] = "true";
    builder_.emplace(load("octomap_builder", parameters));
    status_in_ = node_.create_subscription(topics::sensing_status, [this](const auto& msg) {
      reason_ = msg.reason();
      ++statuses_;
    });
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
      odom_.publish(to_msg(Odometry{robot_, {}}, header(node_.stamp(), "odom"), "base_link"));
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
  // Sends scans that `spoil` has changed until all that is expected has come, or too much time.
  [[nodiscard]] bool wait_with_scans(const std::function<void(sensor_msgs::msg::LaserScan&)>& spoil,
                                     const std::function<bool()>& done) {
    const auto beat = node_.create_wall_timer(0.05, [&] {
      auto msg = scan(3.0F);
      spoil(msg);
      scan_.publish(msg);
    });
    return wait_until(done);
  }
  [[nodiscard]] bool says(const std::string& part) const {
    return reason_ && (part.empty() ? reason_->empty() : reason_->find(part) != std::string::npos);
  }
  // Of a pole on the robot's left, at the scanner's height; or without a point.
  [[nodiscard]] rt::Timer camera_that_sees(bool points) {
    return node_.create_wall_timer(0.05, [this, points] {
      std::vector<Eigen::Vector3f> seen;
      if (points) seen.emplace_back(0.01F, 1.5F, 0.0F);
      cloud_.publish(cloud_of(seen, header(node_.stamp(), "base_scan")));
    });
  }
  [[nodiscard]] bool is_occupied(double x, double y) const {
    const auto* voxel = tree_->search(x, y, 0.3);
    return voxel != nullptr && tree_->isNodeOccupied(voxel);
  }

  CapturedLog log_;
  std::optional<rt::RunningComponent> builder_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ = node_.create_publisher(topics::scan);
  rt::Publisher<sensor_msgs::msg::PointCloud2> cloud_ = node_.create_publisher(topics::cloud_in);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_static_ = node_.create_publisher(topics::tf_static);
  rt::Subscription maps_in_, status_in_;
  rt::Timer odometry_;
  std::unique_ptr<octomap::OcTree> tree_;
  std::string frame_;
  Pose2 robot_ = kRobot;
  std::optional<std::string> reason_;
  long maps_ = 0, statuses_ = 0;
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

// A scanner that sees ahead only, to the left of the map.
TEST_F(BuilderOverDds, CoversWhatItsBeamsPassAndWhereItsOutlineStandsAndNothingElse) {
  const auto is_known = [&](double x, double y, double z) {
    return tree_->search(kRobot.x + x, kRobot.y + y, z) != nullptr;
  };
  auto ahead = scan(3.0F);
  ahead.angle_min(-1.0F);
  ahead.ranges().resize(115);
  const auto beat = node_.create_wall_timer(0.05, [&] {
    ahead.header().stamp(node_.stamp());
    scan_.publish(ahead);
  });
  ASSERT_TRUE(wait_until([&] { return maps_ > 0 && is_known(0.0, -0.3, 0.125); }));
  EXPECT_TRUE(is_known(0.0, 2.0, 0.3));
  EXPECT_FALSE(is_known(0.0, -0.3, 0.3));
  for (const double z : {0.125, 0.3}) EXPECT_FALSE(is_known(0.0, -1.0, z)) << "behind it";
  EXPECT_FALSE(is_known(0.0, 3.3, 0.3)) << "behind the echo";
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

TEST_F(BuilderOverDds, TellsHowItsSensorsAreFromTheStartAndWithoutThem) {
  ASSERT_TRUE(wait_until([&] { return says("nothing is heard on scan or cloud_in"); }));
  ASSERT_TRUE(wait_for_maps(1));
  ASSERT_TRUE(wait_until([&] { return says("scan is silent"); }));
  const long before = statuses_;
  const double began = node_.steady_now();
  ASSERT_TRUE(wait_until([&] { return statuses_ >= before + 20; }));
  EXPECT_LT(node_.steady_now() - began, 4.0);  // 5 Hz
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
}

TEST_F(BuilderOverDds, ABlindScannerIsNamedBesideACameraThatSees) {
  const auto camera = camera_that_sees(true);
  for (const float nothing : {0.0F, std::numeric_limits<float>::quiet_NaN()}) {
    ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
    const auto blind = [&](auto& msg) { msg.ranges().assign(360, nothing); };
    ASSERT_TRUE(wait_with_scans(blind, [&] { return says("scan gives no valid range"); }));
    EXPECT_TRUE(says("no_return"));
  }
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
  ASSERT_TRUE(wait_with_scans([](auto& msg) { msg.ranges().clear(); },
                              [&] { return says("scan gives no valid range (no beams)"); }));
  const long before = maps_;
  EXPECT_TRUE(wait_until([&] { return maps_ > before; }));  // by the camera
  EXPECT_GT(log_.lines("the robot must stand: scan gives no valid range"), 0);
}

TEST_F(BuilderOverDds, ADeadCameraIsNamedBesideAScannerThatSees) {
  auto camera = camera_that_sees(true);
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
  camera = {};
  ASSERT_TRUE(wait_with_scans([](auto&) {}, [&] { return says("cloud_in is silent"); }));
  camera = camera_that_sees(true);
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
}

TEST_F(BuilderOverDds, ACameraThatSeesNothingClearsAndStopsNothing) {
  const auto camera = camera_that_sees(false);
  ASSERT_TRUE(wait_for_maps(1));
  const double until = node_.steady_now() + 1.5;  // three times as long as sensor_timeout
  bool was_told = false;
  ASSERT_TRUE(wait_with_scans([](auto&) {},
                              [&] {
                                was_told = was_told || says("cloud_in");
                                return node_.steady_now() > until;
                              }));
  EXPECT_FALSE(was_told);
  EXPECT_TRUE(says(""));
  EXPECT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
}

TEST_F(BuilderOverDds, AScannerThatTellsItsFarthestReadingAsRangeMaxShowsAWall) {
  const long before = maps_;
  ASSERT_TRUE(
      wait_with_scans([](auto& msg) { msg.range_max(3.0F); }, [&] { return maps_ > before + 2; }));
  EXPECT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
  EXPECT_TRUE(wait_until([&] { return says(""); }));
}

TEST_F(BuilderOverDds, NothingInRangeIsAskedForByItsName) {
  const auto mostly_zero = [](auto& msg) {
    std::fill(msg.ranges().begin() + 100, msg.ranges().end(), 0.0F);
  };
  EXPECT_TRUE(wait_with_scans(mostly_zero, [&] {
    return log_.lines("most beams have been zero") == 1 && log_.lines("parameter no_return") == 1;
  }));
}

TEST_F(BuilderOverDds, EchoesOfTheRobotItselfAreNoObstacles) {
  const auto posts = [](auto& msg) {
    for (std::size_t i = 0; i < 10; ++i) msg.ranges()[i] = 0.3F;
  };
  const long before = maps_;
  ASSERT_TRUE(wait_with_scans(posts, [&] { return maps_ > before + 5; }));
  EXPECT_FALSE(is_occupied(kRobot.x + 0.01, kRobot.y + 0.301));
  EXPECT_TRUE(is_occupied(kRobot.x, kRobot.y - 3.001));
  EXPECT_EQ(log_.lines("scan: 10 echoes of a look lie inside the robot's outline"), 1);
}

TEST_F(BuilderOverDds, RangeMaxWithoutAnEndAndAnOddTimeIncrementAreTaken) {
  const auto odd = [](auto& msg) {
    msg.range_max(std::numeric_limits<float>::infinity());
    msg.time_increment(153333.0F);
  };
  const long before = maps_;
  ASSERT_TRUE(wait_with_scans(odd, [&] { return maps_ > before + 2; }));
  EXPECT_TRUE(is_occupied(kRobot.x + 3.001, kRobot.y));
  EXPECT_EQ(log_.lines("scan: time_increment = 153333 s"), 1);
}

TEST_F(BuilderOverDds, ASensorsClockThatIsOffIsNamed) {
  ASSERT_TRUE(wait_for_maps(1));
  const auto late = [](auto& msg) { msg.header().stamp().sec(msg.header().stamp().sec() - 3); };
  EXPECT_TRUE(wait_with_scans(late, [&] { return says("its stamp is 3.0 s behind odometry's"); }));
  const auto early = [](auto& msg) { msg.header().stamp().sec(msg.header().stamp().sec() + 3); };
  EXPECT_TRUE(wait_with_scans(early, [&] { return says("s ahead of odometry's"); }));
}

TEST_F(BuilderOverDds, AFrozenScannerIsNamedOnceTheWheelsHaveMoved) {
  auto same = scan(2.0F);  // one side of a room, and another
  std::fill(same.ranges().begin(), same.ranges().begin() + 180, 3.0F);
  const auto freeze = [&](auto& msg) { msg.ranges(same.ranges()); };
  ASSERT_TRUE(wait_with_scans(freeze, [&] { return says(""); }));
  const auto drive = node_.create_wall_timer(0.02, [this] { robot_.y += 0.002; });
  EXPECT_TRUE(wait_with_scans(freeze, [&] { return says("scan is frozen"); }));
  EXPECT_GT(robot_.y, kRobot.y + 0.1);
  EXPECT_FALSE(is_occupied(kRobot.x, kRobot.y - 2.001 + 0.1));  // not carried along
}

class BuilderThatNeedsACamera : public BuilderOverDds {
 protected:
  BuilderThatNeedsACamera() : BuilderOverDds{{{"required_sensors", "[cloud_in]"}}} {}
};

TEST_F(BuilderThatNeedsACamera, NamesItUntilItIsHeard) {
  ASSERT_TRUE(wait_with_scans(
      [](auto&) {}, [&] { return says("cloud_in is silent, and required_sensors names it"); }));
  const auto camera = camera_that_sees(false);
  EXPECT_TRUE(wait_with_scans([](auto&) {}, [&] { return says(""); }));
}

class BuilderOfADriverThatSendsRangeMax : public BuilderOverDds {
 protected:
  BuilderOfADriverThatSendsRangeMax() : BuilderOverDds{{{"no_return", "[range_max, nan]"}}} {}
};

TEST_F(BuilderOfADriverThatSendsRangeMax, RefusesARangeMaxThatVaries) {
  const auto hall = [](auto& msg) { msg.ranges().assign(360, msg.range_max()); };
  ASSERT_TRUE(wait_with_scans(hall, [&] { return maps_ > 0 && says(""); }));
  const auto other = [](auto& msg) { msg.range_max(3.0F); };
  EXPECT_TRUE(
      wait_with_scans(other, [&] { return says("scan is refused: its range_max varies"); }));
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

void cover_ground(octomap::OcTree& tree) {
  const auto middle = [](int i) { return 0.05F * (static_cast<float>(i) + 0.5F); };
  for (int ix = -40; ix < 40; ++ix)
    for (int iy = -40; iy < 40; ++iy)
      tree.updateNode(octomap::point3d(middle(ix), middle(iy), 0.3F), false);
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
  ASSERT_TRUE(wait_until([&] { return v == 0.15 && reason == "unseen ground"; }));
  cover_ground(tree);
  msg.data(encode_octomap(tree));
  ASSERT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));

  for (int i = -20; i <= 20; ++i)
    tree.updateNode(octomap::point3d(0.57F, 0.05F * static_cast<float>(i), 0.3F), true);
  msg.data(encode_octomap(tree));
  ASSERT_TRUE(wait_until([&] { return v < 0.3 && reason != "clear"; }));
  looks = {};
  EXPECT_TRUE(wait_until([&] { return v == 0.0 && reason == "octomap_local is silent"; }));
}

// What the builder says of its sensors goes before how fresh the map is.
TEST_F(OneComponent, AFilterWithLiveSensingStandsWhileTheBuilderSaysThatItsSensorsDoNotSee) {
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
  octomap_msgs::msg::Octomap msg;
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(0.05);
  octomap::OcTree tree(0.05);
  cover_ground(tree);
  msg.data(encode_octomap(tree));
  const auto beat = node_.create_wall_timer(0.02, [&] {
    odom.publish(to_msg(Odometry{}, header({}, "odom"), "base_link"));
    command.publish(to_msg(Twist2{0.3, 0.0}));
    map.publish(msg);
  });
  ASSERT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));  // a foreign map source

  auto sensing = std::optional{node_.create_publisher(topics::sensing_status)};
  tandem_msgs::msg::SensingStatus word;
  auto words = node_.create_wall_timer(0.1, [&] { sensing->publish(word); });
  ASSERT_TRUE(wait_until([&] { return sensing->matched() > 0; }));
  ASSERT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));
  word.reason("scan gives no valid range");
  ASSERT_TRUE(wait_until([&] { return v == 0.0 && reason == "scan gives no valid range"; }));
  word.reason("");
  ASSERT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));
  words = {};
  ASSERT_TRUE(wait_until(
      [&] { return v == 0.0 && reason.find("sensing_status is silent") != std::string::npos; }));
  sensing.reset();
  EXPECT_TRUE(wait_until([&] { return v == 0.3 && reason == "clear"; }));
}

// Both over DDS: whichever of two sensors is lost, the robot stands and says which.
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
