// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/user_study/trial.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "dashboard/damaged.hpp"

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr const char* kTask1 =
    R"({"id":7,"method":"manual","task":1,"practice":false,"allowed":4})";
constexpr const char* kTask2 =
    R"({"id":8,"method":"shared","task":2,"practice":false,"allowed":120,"region":[3,1.5,5,3.5]})";

// Half a metre a second along x from (x, y) on, a pose each 0.1 s, until over or for `time` [s].
void drive(Trial& trial, double x, double y, double time, double start = 100.0) {
  for (int i = 0; i <= static_cast<int>(10.0 * time) && !trial.over(); ++i)
    trial.on_robot({x + 0.05 * i, y, 0.0}, start + 0.1 * i);
}

TEST(Trial, OfTask2EndsInTheRegion) {
  Trial trial{parse_trial_request(kTask2)};
  trial.on_clearance(0.6);
  drive(trial, 0.0, 2.0, 60.0);
  EXPECT_TRUE(trial.over());
  const UserTrial measured = trial.measured();
  EXPECT_EQ(measured.method, "shared");
  EXPECT_TRUE(measured.reached);
  EXPECT_NEAR(measured.time, 6.0, 0.11);
  EXPECT_NEAR(measured.path_length, 3.0, 0.06);
  EXPECT_EQ(measured.min_clearance, 0.6);
  EXPECT_EQ(measured.collisions, 0);
}

TEST(Trial, OfTask2ThatMissesTheRegionTakesAllTheTimeItMay) {
  Trial trial{parse_trial_request(kTask2)};
  drive(trial, 0.0, 1.0, 121.0);
  EXPECT_TRUE(trial.over());
  EXPECT_FALSE(trial.measured().reached);
  EXPECT_EQ(trial.measured().time, 120.0);
}

TEST(Trial, OfTask1TakesItsTimeHoweverFarItGoes) {
  Trial still{parse_trial_request(kTask1)}, trial{parse_trial_request(kTask1)};
  drive(trial, 3.5, 2.0, 3.9);  // also through the other task's region
  EXPECT_FALSE(trial.over());
  drive(trial, 5.5, 2.0, 1.0, 104.0);
  EXPECT_TRUE(trial.over());
  EXPECT_NEAR(trial.measured().time, 4.0, 1e-9);
  EXPECT_FALSE(trial.measured().reached);
  for (int i = 0; i <= 40; ++i) still.on_robot({}, 0.1 * i);
  EXPECT_TRUE(still.over());
  EXPECT_EQ(still.measured().path_length, 0.0);
}

TEST(Trial, CountsOnlyCollisionsDuringTheTrial) {
  Trial trial{parse_trial_request(kTask1)};
  trial.on_collisions(5);  // before it
  drive(trial, 0.0, 0.0, 1.0);
  trial.on_collisions(7);
  drive(trial, 0.5, 0.0, 1.0, 101.0);
  EXPECT_EQ(trial.measured().collisions, 2);
  trial.on_collisions(1);  // its simulator has begun anew
  drive(trial, 1.0, 0.0, 5.0, 102.0);
  EXPECT_EQ(trial.measured().collisions, 3);
  trial.on_collisions(2);  // after it
  drive(trial, 4.0, 0.0, 1.0, 110.0);
  EXPECT_EQ(trial.measured().collisions, 3);
  EXPECT_NEAR(trial.measured().time, 4.0, 1e-9);
}

TEST(Trial, TakesItsClearanceFromTheFilterWhenItChecks) {
  Trial trial{parse_trial_request(kTask1)};
  drive(trial, 0.0, 0.0, 0.5);
  EXPECT_EQ(trial.measured().min_clearance, kFarClearance);
  double start = 101.0;
  for (const double clearance : {0.3, kNaN, 0.2, 0.5}) {
    trial.on_clearance(clearance);
    drive(trial, 0.0, 0.0, 0.2, start += 0.5);
  }
  EXPECT_EQ(trial.measured().min_clearance, 0.2);
}

TEST(Trial, ReportsProgressAndFinallyTheResultToThePage) {
  Trial trial{parse_trial_request(kTask1)};
  const auto told = [&] { return nlohmann::json::parse(trial.state()); };
  EXPECT_EQ(told(), nlohmann::json::parse(R"({"id":7,"time":0.0,"collisions":0})"));
  drive(trial, 0.0, 0.0, 2.0);
  EXPECT_NEAR(told().at("time").get<double>(), 2.0, 1e-9);
  EXPECT_FALSE(told().contains("trial"));
  drive(trial, 1.0, 0.0, 3.0, 102.0);
  EXPECT_EQ(told().at("trial"), nlohmann::json(trial.measured()));
  EXPECT_EQ(told().at("trial").at("method"), "manual");
}

TEST(Trial, RefusesInvalidTrials) {
  const std::string good = kTask2;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = good;
    return changed.replace(changed.find(from), from.size(), to);
  };
  for (const auto& text :
       {std::string{}, std::string{"[]"}, std::string{"{}"}, with("\"id\":8", "\"id\":\"8\""),
        with("shared", "=cmd()"), with("\"allowed\":120", "\"allowed\":1e9"),
        with("\"allowed\":120", "\"allowed\":-1"), with("[3,1.5,5,3.5]", "[3,1.5,5]"),
        with("[3,1.5,5,3.5]", "[5,1.5,3,3.5]"), with("[3,1.5,5,3.5]", "[3,1.5,5,1e300]"),
        with("[3,1.5,5,3.5]", "[3,1.5,5,null]"), with("\"practice\":false", "\"practice\":0")})
    EXPECT_THROW((void)parse_trial_request(text), std::invalid_argument) << text;
}

// Parsed requests are valid, and all others are refused in the same way.
TEST(Trial, TakesAnyBytes) {
  const std::vector<std::string> texts{kTask1, kTask2};
  std::mt19937 random{11};
  for (int i = 0; i < 20'000; ++i) {
    try {
      const TrialRequest request = parse_trial_request(test::damaged(texts, random));
      EXPECT_LE(request.asked.allowed, 3600.0);
      Trial trial{request};
      drive(trial, 0.0, 2.0, 0.5);
      EXPECT_FALSE(trial.state().empty());
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace tandem
