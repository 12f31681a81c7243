// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "support/captured_log.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

constexpr double kStart = -3.2;      // [m] x of the start, heading for the pole at (−2, −2)
constexpr double kPoleRim = -2.225;  // [m]
constexpr double kFront = 0.483;     // [m] of the MiR, ahead of base_link

class SimOverDds : public OneComponent {
 protected:
  SimOverDds() {
    odom_in_ = node_.create_subscription(topics::odom, [this](const auto& msg) {
      odom_ = from_msg(msg).value();
      frames_ = msg.header().frame_id() + " " + msg.child_frame_id();
    });
    truth_in_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      truth_ = from_msg(msg).value();
      ++truths_;
    });
    collision_in_ =
        node_.create_subscription(topics::collision, [this](const auto& msg) { collision_ = msg; });
    beat_ = node_.create_wall_timer(0.02, [this] {
      if (push_) command_.publish(to_msg(*push_));
    });
  }

  [[nodiscard]] bool stands() const { return std::abs(truth_.twist.v) < 1e-3; }
  [[nodiscard]] bool wait_until_at_start() {
    return wait_until([&] {
      return truths_ > 0 && stands() && is_near(truth_.X.x, kStart) && is_near(odom_.X.x, 0.0);
    });
  }

  CapturedLog log_;
  rt::RunningComponent sim_ =
      load("diff_drive_sim", {{"map", source_path("maps/forest.bt")},
                              {"start", "[" + std::to_string(kStart) + ", -2.0, 0.0]"},
                              {"people", "[0.25, 1.0, 2, -4.0, -4.5, 4.0, -4.5]"},
                              {"base_timeout", "0.4"}});
  rt::Publisher<geometry_msgs::msg::Twist> command_ = node_.create_publisher(topics::cmd_vel);
  rt::Subscription odom_in_, truth_in_, collision_in_;
  rt::Timer beat_;

  std::optional<Twist2> push_;
  Odometry odom_, truth_;
  std::string frames_;
  long truths_ = 0;
  tandem_msgs::msg::Collision collision_;
};

TEST_F(SimOverDds, ObeysACommandAndStopsWhenCommandsFallSilent) {
  ASSERT_TRUE(wait_until_at_start());
  EXPECT_EQ(frames_, "odom base_link");
  push_ = {-0.3, 0.5};
  ASSERT_TRUE(wait_until([&] { return odom_.X.x < -0.1 && odom_.X.theta > 0.1; }));
  EXPECT_LT(odom_.twist.v, 0.0);
  push_ = {};
  EXPECT_TRUE(wait_until([&] { return stands(); }));
}

TEST_F(SimOverDds, ACommandThatIsNotANumberIsIgnored) {
  ASSERT_TRUE(wait_until_at_start());
  push_ = {-0.3, 0.0};
  ASSERT_TRUE(wait_until([&] { return truth_.twist.v < -0.2; }));
  push_ = {kNaN, 0.0};
  EXPECT_TRUE(wait_until([&] { return stands(); }));
  EXPECT_GE(log_.lines("cmd_vel is not finite: dropped"), 1);
  EXPECT_TRUE(std::isfinite(truth_.X.x));
}

TEST_F(SimOverDds, ResetPutsTheRobotBackToItsStart) {
  ASSERT_TRUE(wait_until_at_start());
  push_ = {-0.4, 0.0};
  ASSERT_TRUE(wait_until([&] { return odom_.X.x < -0.1; }));
  push_ = {};
  ASSERT_TRUE(wait_until([&] { return stands(); }));  // no command is in transit any more
  const auto reset =
      node_.create_client(rt::ServiceName<std_srvs::srv::Trigger>{"/diff_drive_sim/reset"});
  std::string answer;
  reset.call({}, [&](const auto& response) {
    EXPECT_TRUE(response.success());
    answer = response.message();
  });
  ASSERT_TRUE(wait_until([&] { return !answer.empty(); }));
  EXPECT_EQ(answer, "at the start");
  EXPECT_TRUE(wait_until_at_start());
}

TEST_F(SimOverDds, AnInitialPoseMovesTheRobotUnlessItIsNotANumber) {
  ASSERT_TRUE(wait_until_at_start());
  const auto put = node_.create_publisher(topics::initial_pose, rt::kLatched);
  geometry_msgs::msg::PoseWithCovarianceStamped msg;
  msg.pose().pose(to_msg(Pose2{1.0, kNaN, 0.0}));
  put.publish(msg);
  ASSERT_TRUE(wait_until([&] { return log_.lines("initialpose is not finite: dropped") == 1; }));
  EXPECT_TRUE(is_near(truth_.X.x, kStart));
  msg.pose().pose(to_msg(Pose2{-4.0, -3.0, 1.0}));
  put.publish(msg);
  EXPECT_TRUE(wait_until([&] { return is_near(truth_.X.y, -3.0); }));
  EXPECT_NEAR(truth_.X.theta, 1.0, 1e-6);
}

TEST_F(SimOverDds, ReportsAContactUntilTheRobotIsClearAgain) {
  ASSERT_TRUE(wait_until_at_start());
  EXPECT_FALSE(collision_.in_contact());
  push_ = {0.6, 0.0};
  ASSERT_TRUE(wait_until([&] { return collision_.in_contact(); }));
  EXPECT_EQ(collision_.count(), 1u);
  EXPECT_NEAR(collision_.point().x(), kPoleRim, 0.06);  // a cell
  EXPECT_NEAR(collision_.point().y(), -2.0, 0.3);
  ASSERT_TRUE(wait_until([&] { return stands(); }));  // pushed on against the pole
  EXPECT_NEAR(truth_.X.x + kFront, kPoleRim, 0.06);
  push_ = {-0.4, 0.0};
  EXPECT_TRUE(wait_until([&] { return !collision_.in_contact(); }));
  EXPECT_EQ(collision_.count(), 1u);
}

TEST_F(SimOverDds, SaysWherePeopleWalk) {
  std::vector<Obstacle> people;
  std::string frame;
  const auto people_in = node_.create_subscription(topics::people, [&](const auto& msg) {
    people = from_msg(msg).all;
    frame = msg.header().frame_id();
  });
  ASSERT_TRUE(wait_until([&] { return !people.empty() && people[0].p_MO.x() > -3.5; }));
  EXPECT_EQ(people.size(), 1U);
  EXPECT_EQ(frame, "map");
  EXPECT_NEAR(people[0].p_MO.y(), -4.5, 1e-9);
  EXPECT_EQ(people[0].a, 0.25);
  EXPECT_LE(people[0].v_MO.norm(), 1.0 + 1e-9);
}

TEST_F(SimOverDds, ShowsItsClockItsFramesAndWhatItsScannerSees) {
  std::vector<double> clock;
  std::optional<Pose2> X_MW, X_WB;
  sensor_msgs::msg::LaserScan scan;
  const auto clock_in = node_.create_subscription(
      topics::clock, [&](const auto& msg) { clock.push_back(rt::to_seconds(msg.clock())); });
  const auto tf_in = node_.create_subscription(topics::tf, [&](const auto& msg) {
    X_MW = find_transform(msg, "map", "odom");
    X_WB = find_transform(msg, "odom", "base_link");
  });
  const auto scan_in =
      node_.create_subscription(topics::scan, [&](const auto& msg) { scan = msg; });
  std::optional<Eigen::Isometry3d> X_BS;  // of the scanner: told before anybody listened
  const auto tf_static_in = node_.create_subscription(topics::tf_static, [&](const auto& msg) {
    for (const auto& t : msg.transforms())
      if (t.header().frame_id() == "base_link" && t.child_frame_id() == "base_scan")
        X_BS = from_msg(t.transform());
  });
  ASSERT_TRUE(
      wait_until([&] { return clock.size() > 10 && X_MW && X_BS && !scan.ranges().empty(); }));
  EXPECT_TRUE(std::is_sorted(clock.begin(), clock.end()));
  ASSERT_TRUE(X_WB);
  const Pose2 X_MB = compose(*X_MW, *X_WB);
  EXPECT_NEAR(X_MB.x, kStart, 1e-6);
  EXPECT_NEAR(X_MB.y, -2.0, 1e-6);
  EXPECT_EQ(scan.header().frame_id(), "base_scan");
  EXPECT_TRUE(X_BS->isApprox(Eigen::Isometry3d{Eigen::Translation3d(0.0, 0.0, 0.3)}));
  EXPECT_NEAR(scan.time_increment() * 360.0F, scan.scan_time(), 1e-6);
  ASSERT_EQ(scan.ranges().size(), 360u);
  EXPECT_NEAR(scan.ranges()[180], kPoleRim - kStart, 0.06);  // straight ahead: the pole
  EXPECT_NEAR(scan.ranges()[0], 5.0 + kStart, 0.06);         // behind: the wall
}

class RestingSim : public OneComponent {
 protected:
  RestingSim() {
    clock_in_ = node_.create_subscription(topics::clock, [this](const auto& msg) {
      const double time = rt::to_seconds(msg.clock());
      step_ = time - time_;
      equal_steps_ = is_near(step_, last_step_) ? equal_steps_ + 1 : 0;
      last_step_ = step_;
      time_ = time;
    });
    beat_ = node_.create_wall_timer(0.02, [this] { command_.publish(to_msg(push_)); });
  }

  // Waits for several such steps of the clock in a row.
  [[nodiscard]] bool has_steps_of(double seconds) {
    return wait_until([&] { return is_near(step_, seconds) && equal_steps_ >= 5; });
  }

  rt::RunningComponent sim_ = load(
      "diff_drive_sim", {{"map", source_path("maps/forest.bt")}, {"start", "[-4.0, -4.0, 0.0]"}});
  rt::Publisher<geometry_msgs::msg::Twist> command_ = node_.create_publisher(topics::cmd_vel);
  rt::Subscription clock_in_;
  rt::Timer beat_;
  Twist2 push_;
  double time_ = 0.0, step_ = 0.0, last_step_ = 0.0;  // [s]
  int equal_steps_ = 0;
};

TEST_F(RestingSim, ShowsEverySecondStepOfTheTime) {
  ASSERT_TRUE(has_steps_of(0.02));
  push_ = {0.0, 0.5};
  ASSERT_TRUE(has_steps_of(0.01));
  push_ = {};
  EXPECT_TRUE(has_steps_of(0.02));
}

// If the machine is busy, it is late.
TEST_F(RestingSim, KeepsUpWithRealTime) {
  ASSERT_TRUE(has_steps_of(0.02));
  double from = time_, since = rt::steady_seconds();
  EXPECT_TRUE(wait_until([&] {
    const double passed = rt::steady_seconds() - since;
    if (passed < 0.5) return false;
    const double simulated = time_ - from;
    from = time_, since += passed;
    return std::abs(simulated / passed - 1.0) < 0.25;
  }));
}

// Of a robot at rest, two scans differ by noise alone, whose deviation is √2 times that of one.
TEST_F(OneComponent, RangesHaveTheNoiseOfTheParameter) {
  const auto sim = load("diff_drive_sim", {{"map", source_path("maps/forest.bt")},
                                           {"start", "[-4.0, -4.0, 0.0]"},
                                           {"scan_noise", "0.05"}});
  std::vector<std::vector<float>> scans;
  const auto scan_in = node_.create_subscription(
      topics::scan, [&](const auto& msg) { scans.push_back(msg.ranges()); });
  ASSERT_TRUE(wait_until([&] { return scans.size() >= 10; }));
  double sum = 0.0;
  int count = 0;
  for (std::size_t n = 1; n < 10; ++n)
    for (std::size_t i = 0; i < scans[n].size(); ++i) {
      const double difference = scans[n][i] - scans[n - 1][i];
      if (!std::isfinite(difference)) continue;
      sum += difference * difference;
      ++count;
    }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(0.5 * sum / count), 0.05, 0.005);
}

}  // namespace
}  // namespace tandem::test
