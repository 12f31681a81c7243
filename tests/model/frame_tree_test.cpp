// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/frame_tree.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <random>

namespace tandem {
namespace {

Eigen::Isometry3d placed_at(double x, double y, double z, double yaw = 0.0) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

TEST(FrameTree, FollowsLinksUpAndDown) {
  FrameTree tree;
  tree.set("base_link", "mast", placed_at(-0.2, 0.0, 1.0, std::numbers::pi / 2));
  tree.set("mast", "laser", placed_at(0.1, 0.0, 0.05));
  tree.set("base_footprint", "base_link", placed_at(0.0, 0.0, 0.15));
  EXPECT_TRUE(tree.pose("base_link", "base_link")->isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(
      tree.pose("base_link", "laser")->isApprox(placed_at(-0.2, 0.1, 1.05, std::numbers::pi / 2)));
  EXPECT_TRUE(tree.pose("base_footprint", "laser")
                  ->isApprox(placed_at(-0.2, 0.1, 1.2, std::numbers::pi / 2)));
  EXPECT_TRUE(tree.pose("laser", "base_link")
                  ->isApprox(placed_at(-0.2, 0.1, 1.05, std::numbers::pi / 2).inverse()));
  tree.set("base_link", "camera", placed_at(0.3, 0.0, 0.6));  // two branches
  EXPECT_TRUE(
      tree.pose("camera", "mast")->isApprox(placed_at(-0.5, 0.0, 0.4, std::numbers::pi / 2)));
}

TEST(FrameTree, TheLatestTransformCountsAndALeadingSlashDoesNot) {
  FrameTree tree;
  tree.set("/base_link", "laser", placed_at(1.0, 0.0, 0.0));
  tree.set("base_link", "/laser", placed_at(0.2, 0.0, 0.0));
  EXPECT_TRUE(tree.pose("base_link", "/laser")->isApprox(placed_at(0.2, 0.0, 0.0)));
}

TEST(FrameTree, HasNoPoseForUnconnectedFrames) {
  FrameTree tree;
  EXPECT_FALSE(tree.pose("base_link", "laser"));
  tree.set("base_link", "laser", placed_at(0.2, 0.0, 0.0));
  tree.set("map", "beacon", placed_at(5.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "beacon"));
  EXPECT_FALSE(tree.pose("base_link", ""));
}

TEST(FrameTree, TerminatesOnACycleAndIsBounded) {
  FrameTree tree;
  tree.set("a", "b", placed_at(1.0, 0.0, 0.0));
  tree.set("b", "a", placed_at(1.0, 0.0, 0.0));
  tree.set("a", "a", placed_at(1.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "b"));
  for (std::size_t i = 0; i < FrameTree::kMaxFrames; ++i)
    tree.set("base_link", "f" + std::to_string(i), placed_at(0.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "f" + std::to_string(FrameTree::kMaxFrames - 1)));
  EXPECT_TRUE(tree.pose("base_link", "f0"));
}

FrameLink told(std::string_view parent, std::string_view child, const Eigen::Isometry3d& X_PC,
               double arrival, std::optional<double> stamp = {}) {
  return {parent, child, X_PC, {}, arrival, stamp};
}

double x_of(const FrameTree& tree, std::string_view base, std::string_view frame,
            std::optional<double> stamp = {}) {
  const auto found = tree.find(base, frame, stamp);
  return found ? found->X_BF.translation().x() : std::numeric_limits<double>::quiet_NaN();
}

TEST(FrameTree, JoinsMapAndOdomWithSlashesOverAThirdFrameAndTheOtherWayRound) {
  FrameTree slashes;
  slashes.set(told("/map", "/odom", placed_at(1.0, 2.0, 0.0), 0.0));
  EXPECT_TRUE(slashes.pose("map", "odom")->isApprox(placed_at(1.0, 2.0, 0.0)));
  FrameTree third;
  third.set(told("map", "odom_combined", placed_at(1.0, 0.0, 0.0), 0.0));
  third.set(told("odom_combined", "odom", placed_at(0.0, 2.0, 0.0), 0.0));
  EXPECT_TRUE(third.pose("map", "odom")->isApprox(placed_at(1.0, 2.0, 0.0)));
  FrameTree turned;
  const auto X_WM = placed_at(1.0, 2.0, 0.0, 0.7);
  turned.set(told("odom", "map", X_WM, 0.0));
  EXPECT_TRUE(turned.pose("map", "odom")->isApprox(X_WM.inverse()));
}

TEST(FrameTree, TheOldestDynamicLinkOfAChainDecidesItsAge) {
  FrameTree tree;
  tree.set(told("map", "a", placed_at(1.0, 0.0, 0.0), 3.0));
  tree.set_static(told("a", "b", placed_at(1.0, 0.0, 0.0), 1.0));
  tree.set(told("b", "odom", placed_at(1.0, 0.0, 0.0), 2.0));
  tree.set(told("odom", "base_link", placed_at(1.0, 0.0, 0.0), 0.5));
  EXPECT_EQ(tree.find("map", "odom")->arrival, 2.0);
  EXPECT_EQ(tree.find("map", "a")->arrival, 3.0);
  EXPECT_EQ(tree.find("map", "base_link")->arrival, 0.5);
  EXPECT_TRUE(tree.find("a", "b")->is_static());
  tree.set(told("b", "odom", placed_at(1.0, 0.0, 0.0), 5.0));
  EXPECT_EQ(tree.find("map", "odom")->arrival, 3.0);
}

// A localiser publishes map → base_link; the wheels publish base_link → odom at twice the rate.
TEST(FrameTree, LinksThatMoveAreComposedAtTheNewestTimeThatAllOfThemHaveReached) {
  FrameTree tree;
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.05 * i;
    if (i % 2 == 0) tree.set(told("map", "base_link", placed_at(3.0 + t, 0.0, 0.0), t, t));
    tree.set(told("base_link", "odom", placed_at(-t, 0.0, 0.0), t, t));
  }
  tree.set(told("base_link", "odom", placed_at(-1.05, 0.0, 0.0), 1.05, 1.05));
  EXPECT_NEAR(x_of(tree, "map", "odom"), 3.0, 1e-12);
  EXPECT_NEAR(x_of(tree, "map", "base_link", 0.525), 3.525, 1e-12) << "between two samples";
  EXPECT_NEAR(x_of(tree, "map", "base_link", 9.0), 4.0, 1e-12) << "the newest";
  EXPECT_NEAR(x_of(tree, "map", "base_link", -9.0), 3.0, 1e-12) << "the oldest";
  EXPECT_NEAR(tree.find("map", "base_link", 1.2)->drift, 0.2, 1e-9);
}

TEST(FrameTree, ClocksThatAreSecondsApartAreNoChain) {
  FrameTree tree;
  tree.set(told("map", "a", placed_at(1.0, 0.0, 0.0), 0.0, 100.0));
  tree.set(told("a", "odom", placed_at(1.0, 0.0, 0.0), 0.0, 95.0));
  EXPECT_FALSE(tree.find("map", "odom"));
  EXPECT_NE(tree.why_not("map", "odom").find("check the publishers' clocks"), std::string::npos);
  EXPECT_TRUE(tree.find("map", "a")) << "one link alone needs no clock";
  tree.set(told("a", "odom", placed_at(1.0, 0.0, 0.0), 0.0));  // without a timestamp
  EXPECT_TRUE(tree.find("map", "odom"));
}

TEST(FrameTree, ARestartedPublisherIsAccepted) {
  FrameTree tree;
  for (int i = 0; i < 10; ++i) tree.set(told("map", "odom", placed_at(i, 0.0, 0.0), i, 100.0 + i));
  tree.set(told("map", "odom", placed_at(50.0, 0.0, 0.0), 11.0, 0.0));
  EXPECT_EQ(x_of(tree, "map", "odom"), 50.0);
  EXPECT_EQ(x_of(tree, "map", "odom", 105.0), 50.0);
}

TEST(FrameTree, AStaticLinkHoldsUntilADynamicOneArrives) {
  FrameTree tree;
  tree.set_static(told("map", "odom", placed_at(1.0, 0.0, 0.0), 0.0));
  EXPECT_TRUE(tree.find("map", "odom")->is_static());
  tree.set(told("map", "odom", placed_at(2.0, 0.0, 0.0), 1.0));
  EXPECT_EQ(tree.find("map", "odom")->arrival, 1.0);
  EXPECT_EQ(tree.set_static(told("map", "odom", placed_at(1.0, 0.0, 0.0), 2.0)), LinkFate::kTaken);
  EXPECT_EQ(x_of(tree, "map", "odom"), 2.0);
}

TEST(FrameTree, AFrameWithTwoParentsHasTheNewerAndBothAreNamedWithTheirSenders) {
  FrameTree tree;
  FrameLink wheels = told("odom", "base_link", placed_at(1.0, 0.0, 0.0), 1.0);
  FrameLink filter = told("/odom_combined", "/base_link", placed_at(2.0, 0.0, 0.0), 2.0);
  wheels.sender[0] = 1;
  filter.sender[0] = 2;
  EXPECT_EQ(tree.set(wheels), LinkFate::kTaken);
  EXPECT_EQ(tree.set(wheels), LinkFate::kTaken);
  EXPECT_TRUE(tree.two_parents().empty());
  EXPECT_EQ(tree.set(filter), LinkFate::kTwoParents);
  const TwoParents& two = tree.two_parents().at("base_link");
  EXPECT_EQ(two.parent, "odom_combined");
  EXPECT_EQ(two.other, "odom");
  EXPECT_EQ(two.sender, filter.sender);
  EXPECT_EQ(two.other_sender, wheels.sender);
  EXPECT_EQ(two.t, 2.0);
  EXPECT_EQ(x_of(tree, "odom_combined", "base_link"), 2.0);
  EXPECT_FALSE(tree.find("odom", "base_link"));
  EXPECT_NE(tree.why_not("odom", "base_link").find("has two parents"), std::string::npos);
}

TEST(FrameTree, ErrorsNameWhatIsMissingAndWhatExists) {
  FrameTree tree;
  EXPECT_EQ(tree.why_not("map", "odom"), "no transform has arrived on /tf or /tf_static");
  tree.set(told("map", "odom_combined", placed_at(0.0, 0.0, 0.0), 0.0));
  EXPECT_EQ(tree.why_not("map", "odom"), "`odom` is not on /tf; frames there: map → odom_combined");
  tree.set(told("odom", "base_link", placed_at(0.0, 0.0, 0.0), 0.0));
  EXPECT_EQ(tree.why_not("/map", "/odom"),
            "no transform on /tf connects `map` and `odom`: odom → base_link, map → odom_combined");
  for (int i = 0; i < 100; ++i)
    tree.set("base_link", "joint_" + std::to_string(i), placed_at(0.0, 0.0, 0.0));
  EXPECT_NE(tree.listing().find(" and 90 more"), std::string::npos) << tree.listing();
}

TEST(FrameTree, KnowsWhichFramesARobotMovesIn) {
  FrameTree tree;
  tree.set(told("map", "odom", placed_at(0.0, 0.0, 0.0), 0.0));
  tree.set(told("odom", "base_footprint", placed_at(0.0, 0.0, 0.0), 0.0));
  tree.set("base_footprint", "base_link", placed_at(0.0, 0.0, 0.1));
  tree.set(told("base_link", "mast", placed_at(0.0, 0.0, 0.1), 0.0));
  for (const char* frame : {"map", "/odom"}) EXPECT_TRUE(tree.is_above(frame, "base_link"));
  for (const char* frame : {"base_footprint", "base_link", "mast", "other"})
    EXPECT_FALSE(tree.is_above(frame, "base_link")) << frame;
}

TEST(FrameTree, RefusesFramesWithoutNameAndThoseThatAreTheirOwnParent) {
  FrameTree tree;
  EXPECT_EQ(tree.set(told("", "a", placed_at(0.0, 0.0, 0.0), 0.0)), LinkFate::kUnnamed);
  EXPECT_EQ(tree.set(told("a", "/", placed_at(0.0, 0.0, 0.0), 0.0)), LinkFate::kUnnamed);
  EXPECT_EQ(tree.set(told("a", std::string(300, 'x'), placed_at(0.0, 0.0, 0.0), 0.0)),
            LinkFate::kUnnamed);
  EXPECT_EQ(tree.set(told("/a", "a", placed_at(0.0, 0.0, 0.0), 0.0)), LinkFate::kLoop);
  EXPECT_EQ(tree.listing(), "none");
}

TEST(FrameTree, DynamicTransformsHaveNoAgeAfterTheClockJumpedBack) {
  FrameTree tree;
  tree.set(told("map", "odom", placed_at(1.0, 0.0, 0.0), 100.0));
  tree.set_static(told("odom", "fixed", placed_at(1.0, 0.0, 0.0), 100.0));
  tree.on_time_jump();
  EXPECT_LT(tree.find("map", "odom")->arrival, 0.0);
  EXPECT_TRUE(tree.find("odom", "fixed")->is_static());
}

// Publishes base_link → `frame` at 50 Hz from time 0 on, with or without stamps.
class MovingFrame : public ::testing::TestWithParam<bool> {
 protected:
  void publish(int steps, const std::function<Eigen::Isometry3d(double)>& X_BF) {
    for (int i = 0; i < steps; ++i, t_ += 0.02)
      tree_.set(told("base_link", "frame", X_BF(t_), t_,
                     GetParam() ? std::optional{1000.0 + t_} : std::nullopt));
  }
  [[nodiscard]] double moved() const { return tree_.moved("base_link", "frame"); }

  FrameTree tree_;
  double t_ = 0.0;
};

INSTANTIATE_TEST_SUITE_P(Stamps, MovingFrame, ::testing::Values(true, false));

TEST_P(MovingFrame, HasMovedByWhatItTravelledWithinTheWindow) {
  publish(101, [](double t) { return placed_at(0.3 * t, 0.0, 1.0); });
  EXPECT_NEAR(moved(), 0.3 * FrameTree::kMotionWindow, 1e-9);
  EXPECT_NEAR(tree_.moved("frame", "base_link"), moved(), 1e-9);
}

TEST_P(MovingFrame, ATurretHasMovedAsAPointOneMetreAway) {
  publish(101, [](double t) { return placed_at(0.1, 0.0, 1.0, 0.3 * t); });
  EXPECT_NEAR(moved(), 0.3 * FrameTree::kMotionWindow, 1e-9);
}

TEST_P(MovingFrame, ATurretThatIsBackWhereItWasHasMoved) {
  publish(101, [](double t) {
    return placed_at(0.0, 0.0, 1.0, 0.2 * std::sin(2.0 * std::numbers::pi * t));
  });
  EXPECT_GT(moved(), 0.15);
}

TEST_P(MovingFrame, TheOpticalFrameOfACameraOnATurretHasMoved) {
  const auto optical = Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  publish(101, [&](double t) { return placed_at(0.0, 0.0, 1.0, 0.3 * t) * optical; });
  EXPECT_NEAR(moved(), 0.3 * FrameTree::kMotionWindow, 1e-9);
}

TEST_P(MovingFrame, AFrameThatCameToRestHasNotMovedOnceTheWindowIsOver) {
  publish(51, [](double t) { return placed_at(0.3 * t, 0.0, 1.0); });
  publish(51, [](double) { return placed_at(0.3, 0.0, 1.0); });
  EXPECT_NEAR(moved(), 0.0, 1e-2);
  publish(2, [](double) { return placed_at(0.3, 0.0, 1.0); });
  EXPECT_NEAR(moved(), 0.0, 1e-9);
}

TEST_P(MovingFrame, ANewOffsetCountsWithinTheWindowOnly) {
  publish(51, [](double) { return placed_at(0.2, 0.0, 1.0); });
  publish(5, [](double) { return placed_at(0.4, 0.0, 1.0, 0.5); });
  EXPECT_NEAR(moved(), 0.7, 1e-9);
  publish(60, [](double) { return placed_at(0.4, 0.0, 1.0, 0.5); });
  EXPECT_NEAR(moved(), 0.0, 1e-9);
}

// base_link on springs or two wheels above base_footprint: only roll, pitch and height change.
TEST_P(MovingFrame, ASwayingBodyHasNotMovedInThePlaneOfTheLevelFrame) {
  publish(101, [](double t) -> Eigen::Isometry3d {
    return Eigen::Translation3d(0.0, 0.0, 0.4 + 0.02 * std::sin(9.0 * t)) *
           Eigen::AngleAxisd(0.2 * std::sin(7.0 * t), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(0.1 * std::sin(5.0 * t), Eigen::Vector3d::UnitX());
  });
  // Interpolation between two samples leaves a little yaw.
  EXPECT_LT(moved(), 1e-3);
  EXPECT_LT(tree_.moved("frame", "base_link"), 1e-3) << "and the other way round";
}

// An estimator that publishes a fixed link: each value is off by up to 1 cm and 0.01 rad.
TEST_P(MovingFrame, NoiseIsLessThanTheMotionThatIsAllowed) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> off{-0.01, 0.01};
  for (int i = 0; i < 500; ++i) {
    publish(1, [&](double) {
      return placed_at(0.2 + off(random), off(random), 1.0 + off(random), off(random));
    });
    ASSERT_LT(moved(), 0.05) << "FramesInput::kMaxMotion";
  }
}

TEST(FrameTree, ALinkThatIsStaticOrUnknownHasNotMoved) {
  FrameTree tree;
  tree.set_static(told("base_link", "laser", placed_at(0.2, 0.0, 0.0), 0.0, 0.0));
  tree.set_static(told("base_link", "laser", placed_at(0.9, 0.0, 0.0), 0.5, 0.5));
  EXPECT_EQ(tree.moved("base_link", "laser"), 0.0);
  EXPECT_EQ(tree.moved("base_link", "base_link"), 0.0);
  EXPECT_EQ(tree.moved("base_link", "other"), 0.0);
}

// Two frames that move in odom with the robot, so the chain between them leads over odom.
TEST(FrameTree, FramesThatMoveTogetherHaveNotMovedAgainstEachOther) {
  FrameTree tree;
  for (double t = 0.0; t < 3.0; t += 0.02) {
    tree.set(told("odom", "base_link", placed_at(0.8 * t, 0.0, 0.0), t, t));
    tree.set(told("odom", "camera", placed_at(0.8 * t + 0.3, 0.0, 0.0), t + 0.01, t + 0.01 - 0.1));
  }
  // The camera's stamps are 0.09 s earlier, so it runs ahead by a constant distance.
  EXPECT_LT(tree.moved("base_link", "camera"), 1e-9);
  EXPECT_GT(tree.moved("odom", "camera"), 0.7);
}

}  // namespace
}  // namespace tandem
