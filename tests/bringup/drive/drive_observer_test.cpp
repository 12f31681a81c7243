// SPDX-License-Identifier: Apache-2.0
// Tests an observer's counters when the nodes were running long before it subscribed.
#include "bringup/drive/drive_observer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "support/paths.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

class Observed : public testing::Test {
 protected:
  explicit Observed(const std::string& scenario = "corridor") {
    const Scenario drive = with_options(
        load_scenario(test::source_path("bringup/scenarios/" + scenario + ".yaml")), {});
    const System system = system_of(drive, {});
    drive_.emplace(drive, system, drive_world(drive, system));
  }

  void robot(double t) { drive_->on_robot({Pose2{1.0, 0.0, 0.0}, {}}, t); }
  void collided(std::uint32_t count) {
    tandem_msgs::msg::Collision msg;
    msg.count(count);
    drive_->on_collision(msg);
  }
  void planned(std::uint64_t cycles, std::uint64_t fallbacks = 0, std::uint64_t overruns = 0) {
    tandem_msgs::msg::PlannerStatus msg;
    msg.cycles(cycles);
    msg.fallbacks(fallbacks);
    msg.overruns(overruns);
    msg.solve_time(0.01);
    drive_->on_plan(msg);
  }
  void filtered(double t, std::uint64_t interventions, Reason reason = Reason::kClear) {
    tandem_msgs::msg::FilterStatus msg;
    msg.header().stamp(rt::to_stamp(std::llround(t * 1e9)));
    msg.reason_code(to_msg(reason));
    msg.interventions(interventions);
    drive_->on_filter(msg);
  }
  void person() { drive_->on_user(geometry_msgs::msg::Twist{}); }

  [[nodiscard]] DriveResult result() const { return drive_->log().result; }

  std::optional<DriveObserver> drive_;
};

TEST_F(Observed, CountsFromTheStartIfItReceivedTheStart) {
  collided(0), planned(0), filtered(0.0, 0, Reason::kNoCommand);
  person();
  robot(0.01), filtered(0.06, 0), planned(1, 1, 1), collided(1);
  robot(0.11), filtered(0.11, 1, Reason::kSlowed), planned(2, 1, 2), collided(2);
  robot(0.16), filtered(0.16, 2, Reason::kSlowed), filtered(0.21, 2);
  const DriveResult r = result();
  EXPECT_EQ(r.collisions, 2);
  EXPECT_EQ(r.counts.plans, 2);
  EXPECT_EQ(r.counts.plan_fallbacks, 1);
  EXPECT_EQ(r.counts.plan_overruns, 2);
  EXPECT_EQ(r.counts.plan_ms.size(), 2U);
  EXPECT_EQ(r.counts.filter_commands, 4);
  EXPECT_EQ(r.counts.filter_interventions, 2);
  EXPECT_EQ(r.counts.filter_episodes, 1);
}

TEST_F(Observed, ThePlannersFirstStatusMayReportItsFirstPlan) {
  person();
  planned(1, 1), planned(2, 1);
  EXPECT_EQ(result().counts.plans, 2);
  EXPECT_EQ(result().counts.plan_fallbacks, 1);
}

// As from a recording that was started while the nodes had long been running.
TEST_F(Observed, LeavesOutWhatWasCountedBeforeIt) {
  collided(7), planned(400, 12, 5), filtered(80.0, 900, Reason::kSlowed);
  person();
  robot(80.01), collided(8), planned(401, 13, 5), filtered(80.06, 901, Reason::kSlowed);
  robot(80.06), planned(402, 13, 6), filtered(80.11, 901);
  const DriveResult r = result();
  EXPECT_EQ(r.collisions, 1);
  EXPECT_EQ(r.counts.plans, 2);
  EXPECT_EQ(r.counts.plan_fallbacks, 1);
  EXPECT_EQ(r.counts.plan_overruns, 1);
  EXPECT_EQ(r.counts.filter_commands, 2);
  EXPECT_EQ(r.counts.filter_interventions, 1);
}

TEST_F(Observed, LeavesOutWhatWasCountedBeforeTheDrive) {
  collided(0), planned(0), filtered(0.0, 0);
  collided(1), planned(1, 1), filtered(0.06, 1, Reason::kSlowed);
  person();
  robot(0.1);
  const DriveResult r = result();
  EXPECT_EQ(r.collisions, 0);
  EXPECT_EQ(r.counts.plans, 0);
  EXPECT_EQ(r.counts.plan_fallbacks, 0);
  EXPECT_EQ(r.counts.filter_commands, 0);
}

TEST_F(Observed, KeepsCountingAcrossANodesRestart) {
  person();
  collided(7), planned(400, 12, 5), filtered(80.0, 900);
  collided(8), planned(401, 13, 6), filtered(80.06, 901, Reason::kSlowed);
  collided(0), planned(0), filtered(80.11, 0);
  collided(2), planned(1, 1, 1), filtered(80.16, 1, Reason::kSlowed);
  robot(80.2);
  const DriveResult r = result();
  EXPECT_EQ(r.collisions, 3);
  EXPECT_EQ(r.counts.plans, 2);
  EXPECT_EQ(r.counts.plan_fallbacks, 2);
  EXPECT_EQ(r.counts.plan_overruns, 2);
  EXPECT_EQ(r.counts.filter_commands, 4);
  EXPECT_EQ(r.counts.filter_interventions, 2);
}

TEST_F(Observed, AStatusThatReportsAReasonIsNotAPlan) {
  person();
  planned(400), planned(401), planned(401), planned(401);
  EXPECT_EQ(result().counts.plans, 1);
  EXPECT_EQ(result().counts.plan_ms.size(), 1U);
}

// Twice a second the filter changes what it gets, for a quarter of a second; it may speak at any
// rate.
class AtRate : public Observed, public testing::WithParamInterface<double> {};

TEST_P(AtRate, InterventionShareIsAShareOfTimeAtAnyPublishingRate) {
  std::uint64_t interventions = 0;
  person();
  for (int n = 0; n < std::lround(10.0 * GetParam()); ++n) {
    const double t = 100.0 + n / GetParam();
    const bool changed = std::fmod(t + 1e-6, 0.5) < 0.25;
    if (changed) ++interventions;
    filtered(t, interventions, changed ? Reason::kSlowed : Reason::kClear);
  }
  const DriveCounts counts = result().counts;
  EXPECT_EQ(counts.filter_commands, 200);
  EXPECT_NEAR(static_cast<double>(counts.filter_interventions), 100.0, 1.0);  // the first word
  EXPECT_EQ(counts.filter_episodes, 20);
}

INSTANTIATE_TEST_SUITE_P(Filter, AtRate, testing::Values(20.0, 40.0, 100.0));

TEST_F(Observed, AFilterWithoutACommandCountsNoIntervention) {
  person();
  filtered(1.0, 0), filtered(1.06, 0, Reason::kNoCommand), filtered(1.11, 0);
  EXPECT_EQ(result().counts.filter_commands, 2);
}

TEST_F(Observed, SeparatesMovingPeopleFromStaticObstacles) {
  const Obstacle pole{.id = 1, .p_MO = {2.0, 0.0}, .a = 0.1, .b = 0.1};
  Obstacle person{.id = 9, .a = 0.25, .b = 0.25, .v_MO = {0.0, 0.5}};
  const auto seen = [&] { drive_->on_obstacles(to_msg(std::vector{pole, person}, {})); };
  for (int i = 0; i < 5; ++i, person.p_MO.y() += 0.2) seen();
  person.v_MO.setZero();  // stops, for a moment
  seen();
  const DriveLog log = drive_->log();
  ASSERT_EQ(log.obstacles.size(), 1U);
  EXPECT_EQ(log.obstacles[0].id, pole.id);
  ASSERT_EQ(log.walks.size(), 1U);
  EXPECT_EQ(log.walks.at(9).radius, 0.25);
  EXPECT_EQ(log.walks.at(9).p_MO.size(), 6U);
}

TEST_F(Observed, AcceptsStampedCommandsOfThePerson) {
  geometry_msgs::msg::TwistStamped msg;
  msg.twist().linear().x(0.5);
  drive_->on_user(msg);
  EXPECT_TRUE(drive_->driving());
}

class Autonomous : public Observed {
 protected:
  Autonomous() : Observed{"table_3_1"} {}
};

TEST_F(Autonomous, TheFirstPlanBeginsTheDriveAndCounts) {
  planned(0);
  EXPECT_FALSE(drive_->driving());
  planned(1);
  EXPECT_TRUE(drive_->driving());
  EXPECT_EQ(result().counts.plans, 1);
}

}  // namespace
}  // namespace tandem
