// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/transit.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace tandem::runtime {
namespace {

constexpr double kLifespan = 0.2;  // [s]
constexpr double kPeriod = 0.05;   // [s]

// A writer's samples, each `ahead` [s] of our clock and `way` [s] under way.
class Link {
 public:
  explicit Link(double ahead) : ahead_{ahead} {}

  bool sample(double way) {
    const bool late = transit_.is_late(now_ + ahead_, now_ + way, kLifespan);
    now_ += kPeriod;
    return late;
  }
  int late_of(int samples, double way) {
    int late = 0;
    for (int i = 0; i < samples; ++i) late += sample(way) ? 1 : 0;
    return late;
  }
  // What was sent in the last `length` seconds comes all at once.
  int late_of_burst(double length) {
    const double taken = now_;
    int late = 0;
    for (double sent = taken - length; sent < taken - 1e-9; sent += kPeriod)
      late += transit_.is_late(sent + ahead_, taken, kLifespan) ? 1 : 0;
    return late;
  }
  void wait(double seconds) { now_ += seconds; }
  void set_clock(double by) { ahead_ += by; }

 private:
  Transit transit_;
  double now_ = 1.7e9;  // [s]
  double ahead_;
};

TEST(Transit, NothingIsLateOnASteadyLink) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> way{0.0, kLifespan};
  for (const double ahead : {0.0, -3600.0, 1e6}) {
    Link link{ahead};
    for (int i = 0; i < 10000; ++i) EXPECT_FALSE(link.sample(way(random)));
  }
}

TEST(Transit, WhatWaitedInAQueueIsLateWhateverTheClocksSay) {
  for (const double ahead : {0.0, -3600.0, 1e6}) {
    Link link{ahead};
    EXPECT_EQ(link.late_of(100, 0.001), 0);
    link.wait(3.0);
    EXPECT_EQ(link.late_of_burst(3.0), 56);  // all but the last 0.2 s, four periods
    EXPECT_EQ(link.late_of(100, 0.001), 0);
  }
}

TEST(Transit, FollowsAClockThatIsSetAndOneThatDrifts) {
  Link link{0.0};
  EXPECT_EQ(link.late_of(100, 0.001), 0);
  link.set_clock(-5.0);  // the writer's: it seems to take 5 s
  EXPECT_NEAR(link.late_of(100, 0.001), Transit::kForGood / kPeriod, 2.0);
  link.set_clock(5.0);
  EXPECT_EQ(link.late_of(100, 0.001), 0);
  for (int i = 0; i < 100000; ++i) {
    link.set_clock(-1e-4 * kPeriod);
    EXPECT_FALSE(link.sample(0.001));
  }
}

TEST(Transit, WithoutALifespanNothingIsLate) {
  Transit transit;
  EXPECT_FALSE(transit.is_late(100.0, 100.0, std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(transit.is_late(0.0, 200.0, std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace tandem::runtime
