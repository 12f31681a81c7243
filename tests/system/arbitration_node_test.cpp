// SPDX-License-Identifier: Apache-2.0
// Tests arbitration over DDS: its inputs, the emergency stop, its services and the clock.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "system/not_finite.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

class ArbitrationOverDds : public OneComponent {
 protected:
  ArbitrationOverDds() {
    out_ = node_.create_subscription(topics::cmd_vel_arbitrated, [this](const auto& msg) {
      v_ = msg.linear().x();
      sound_ = sound_ && from_msg(msg);
      ++commands_;
    });
    status_ = node_.create_subscription(topics::arbitration_status, [this](const auto& msg) {
      reason_ = from_msg(msg.reason_code());
      words_ = msg.reason();
    });
    diagnostics_ = node_.create_subscription(topics::diagnostics, [this](const auto& msg) {
      for (const auto& status : msg.status()) diagnosis_ = {status.level(), status.message()};
    });
    log_ = node_.create_subscription(rt::Topic<rcl_interfaces::msg::Log>{"/rosout", rt::kDefault},
                                     [this](const auto& line) { logged_.push_back(line.msg()); });
    push_ = node_.create_wall_timer(0.03, [this] { user_.publish(to_msg(Twist2{push_v_, 0.0})); });
  }

  rt::RunningComponent arbitration_ = rt::load_component(
      "arbitration", options("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}}));
  rt::Publisher<geometry_msgs::msg::Twist> user_ = node_.create_publisher(topics::cmd_vel_user);
  rt::Subscription out_, status_, diagnostics_, log_;
  rt::Timer push_;
  double push_v_ = 0.5, v_ = 0.0;
  long commands_ = 0;
  bool sound_ = true;  ///< all output was finite
  Reason reason_ = Reason::kNone;
  std::string words_;  ///< the same as a text
  std::vector<std::string> logged_;
  std::pair<int, std::string> diagnosis_;  ///< level and message
};

TEST_F(ArbitrationOverDds, PassesThePersonOnAndStopsWhenTheyFallSilent) {
  ASSERT_TRUE(wait_until([&] { return v_ == 0.5; }));
  push_ = {};
  ASSERT_TRUE(wait_until([&] { return v_ == 0.0; }));
  EXPECT_TRUE(wait_until([&] { return reason_ == Reason::kUserSilent; }));
}

TEST_F(ArbitrationOverDds, ACommandThatIsNotANumberIsIgnored) {
  ASSERT_TRUE(wait_until([&] { return v_ == 0.5; }));
  push_v_ = kNaN;
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0; }));
}

// Arbitration also reports the complaints of planner and filter, so that one topic shows
// everything.
TEST_F(ArbitrationOverDds, ReportsInStatusAndDiagnosticsWhyTheRobotStandsWhateverStoppedIt) {
  using namespace diagnostic_msgs::msg::DiagnosticStatus_Constants;
  const auto says = [&](int level, const std::string& why) {
    return wait_until([&] { return words_ == why && diagnosis_ == std::pair{level, why}; });
  };
  EXPECT_TRUE(says(OK, "in charge"));
  const auto filter = node_.create_publisher(topics::filter_status);
  tandem_msgs::msg::FilterStatus refusal;
  refusal.reason("not localized");
  rt::Timer beat = node_.create_wall_timer(0.02, [&] { filter.publish(refusal); });
  EXPECT_TRUE(says(WARN, "safety filter: not localized"));
  logged_.clear();
  refusal.reason("slowed");
  refusal.scale(0.5);
  EXPECT_TRUE(says(OK, "in charge"));
  EXPECT_TRUE(wait_until([&] {
    return !logged_.empty() && logged_.back().starts_with("user: in charge");
  })) << "the log ends with a trouble that is over";
  beat = {};
  EXPECT_TRUE(says(WARN, "safety filter is silent"));
  push_ = {};
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0; }));
}

TEST_F(ArbitrationOverDds, ReportsWhyThePersonsStickMovesNothing) {
  push_ = {};
  ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kUserSilent; }));
  const auto teleop = node_.create_publisher(topics::teleop_status);
  std_msgs::msg::String trouble;
  trouble.data(text_of(Reason::kStickMoved));
  rt::Timer beat = node_.create_wall_timer(0.05, [&] { teleop.publish(trouble); });
  EXPECT_TRUE(wait_until([&] { return reason_ == Reason::kStickMoved; }));
  EXPECT_TRUE(wait_until([&] { return diagnosis_.second == trouble.data(); }));
  beat = {};
  EXPECT_TRUE(wait_until([&] { return reason_ == Reason::kUserSilent; }));
}

// Non-finite values in unused fields have no effect. Otherwise the command is dropped and the
// timeout stops the robot.
TEST_F(ArbitrationOverDds, NeverForwardsANonFiniteNumberOfAnyCommand) {
  push_ = {};
  auto nav = node_.create_publisher(topics::cmd_vel_nav);
  auto shared = node_.create_publisher(topics::cmd_vel_shared);
  ASSERT_TRUE(wait_until([&] { return nav.matched() * shared.matched() * user_.matched() > 0; }));
  const auto numbers = twist_numbers<geometry_msgs::msg::Twist>([](auto& m) -> auto& { return m; });
  const auto client =
      node_.create_client(rt::ServiceName<tandem_msgs::srv::SetPolicy>{"/arbitration/set_policy"});
  for (const char* policy : {"manual", "shared", "blend", "adaptive", "autonomous"}) {
    tandem_msgs::srv::SetPolicy_Request request;
    request.policy(policy);
    bool set = false;
    client.call(request, [&](const auto& response) { set = response.success(); });
    ASSERT_TRUE(wait_until([&] { return set; }));
    for (const auto& number : numbers)
      for (const double value : kNotFinite) {
        geometry_msgs::msg::Twist bad = to_msg(Twist2{0.3, 0.1});
        number(bad, value);
        for (auto* sender : {&nav, &shared, &user_}) sender->publish(bad);
        const long before = commands_;
        ASSERT_TRUE(wait_until([&] { return commands_ > before; }));
      }
  }
  EXPECT_TRUE(sound_);
}

TEST_F(ArbitrationOverDds, EmergencyStopIsReceivedFromEveryKindOfPublisher) {
  const rt::Client<std_srvs::srv::Trigger> client = node_.create_client(
      rt::ServiceName<std_srvs::srv::Trigger>{"/arbitration/release_emergency_stop"});
  ASSERT_TRUE(wait_until([&] { return v_ == 0.5; }));
  for (const rt::QoS& qos : {rt::kLatched, rt::kDefault, rt::kBestEffort(1)}) {
    const auto button = node_.create_publisher(topics::e_stop, qos);
    ASSERT_TRUE(wait_until([&] { return button.matched() > 0; }));
    std_msgs::msg::Bool pressed;
    pressed.data(true);
    button.publish(pressed);
    ASSERT_TRUE(wait_until([&] { return v_ == 0.0; }));
    EXPECT_TRUE(wait_until([&] { return reason_ == Reason::kEmergencyStop; }));
    pressed.data(false);
    button.publish(pressed);
    bool released = false;
    while (!released) {  // `false` and the request travel on different topics
      bool answered = false;
      client.call({}, [&](const auto& response) {
        released = response.success();
        answered = true;
      });
      ASSERT_TRUE(wait_until([&] { return answered; }));
    }
    EXPECT_TRUE(wait_until([&] { return reason_ == Reason::kLetGoFirst; }));
    EXPECT_EQ(v_, 0.0);
    push_v_ = 0.0;
    ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kSteerFirst; }));
    push_v_ = 0.5;
    ASSERT_TRUE(wait_until([&] { return v_ == 0.5; }));
  }
}

// Two buttons and the service that releases.
class EmergencyStopOverDds : public ArbitrationOverDds {
 protected:
  [[nodiscard]] rt::Publisher<std_msgs::msg::Bool> button(const rt::QoS& qos) {
    return node_.create_publisher(topics::e_stop, qos);
  }
  // A reliable publisher matches two readers, a best effort one one, a latched one three.
  [[nodiscard]] bool is_known(const rt::Publisher<std_msgs::msg::Bool>& button, int readers) {
    return wait_until([&] { return button.matched() == readers; });
  }
  static void say(const rt::Publisher<std_msgs::msg::Bool>& button, bool pressed) {
    std_msgs::msg::Bool msg;
    msg.data(pressed);
    button.publish(msg);
  }
  // The answer to one request.
  [[nodiscard]] bool is_released() {
    std::optional<bool> released;
    client_.call({}, [&](const auto& response) { released = response.success(); });
    return wait_until([&] { return released.has_value(); }) && *released;
  }
  // The word and the request travel on different topics.
  [[nodiscard]] bool is_released_soon() {
    return wait_until([&] { return is_released(); });
  }

  rt::Client<std_srvs::srv::Trigger> client_ = node_.create_client(
      rt::ServiceName<std_srvs::srv::Trigger>{"/arbitration/release_emergency_stop"});
};

TEST_F(EmergencyStopOverDds, IsNotWithdrawnByAnotherPublisherWhileOneThatIsAliveSendsTrue) {
  const auto pressed = button(rt::kLatched), other = button(rt::kDefault);
  ASSERT_TRUE(is_known(pressed, 3) && is_known(other, 2));
  say(pressed, true);
  ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kEmergencyStop; }));
  say(other, true);
  for (int i = 0; i < 20; ++i) {
    say(other, false);
    ASSERT_FALSE(is_released());
  }
  say(pressed, false);
  EXPECT_TRUE(is_released_soon());
}

// Its own middleware would warn a volatile publisher of a latched reader.
TEST_F(EmergencyStopOverDds, IsReadLatchedOnlyBesideALatchedPublisher) {
  const auto latched_readers = [&] {
    long readers = 0;
    for (const auto& topic : node_.topics())
      if (topic.name == "/e_stop")
        readers += std::count_if(topic.subscriptions.begin(), topic.subscriptions.end(),
                                 [](const auto& reader) { return reader.durability >= 1; });
    return readers;
  };
  const auto usual = button(rt::kDefault);
  ASSERT_TRUE(is_known(usual, 2));
  EXPECT_EQ(latched_readers(), 0);
  auto latched = button(rt::kLatched);
  say(latched, true);  // before anybody reads it
  ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kEmergencyStop; }));
  ASSERT_TRUE(is_known(latched, 3));
  latched = {};
  EXPECT_TRUE(wait_until([&] { return latched_readers() == 0; }));
  say(usual, false);
  EXPECT_TRUE(is_released_soon());
}

TEST_F(EmergencyStopOverDds, FromAProgramThatLeftStaysUntilAnyPublisherSendsFalse) {
  auto pressed = button(rt::kDefault);
  const auto other = button(rt::kBestEffort(10));
  ASSERT_TRUE(is_known(pressed, 2) && is_known(other, 1));
  say(pressed, true);
  ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kEmergencyStop; }));
  say(other, false);
  EXPECT_FALSE(is_released());
  pressed = {};
  EXPECT_FALSE(is_released());
  EXPECT_TRUE(wait_until([&] {
    say(other, false);
    return is_released();
  }));
}

// One that presses, takes it back and leaves, 30 times: every `false` is taken, and no reader
// brings an older `true` after it.
TEST_F(EmergencyStopOverDds, FromAShortLivedPublisherIsWithdrawnByOneFalseEachTime) {
  for (int i = 0; i < 30; ++i) {
    const rt::QoS qos = i % 2 == 0 ? rt::kLatched : rt::kDefault;
    {
      const auto pressed = button(qos);
      ASSERT_TRUE(wait_until([&] { return pressed.matched() > 0; }));
      say(pressed, true);
      ASSERT_TRUE(wait_until([&] { return reason_ == Reason::kEmergencyStop; }));
    }
    const auto other = button(qos);
    ASSERT_TRUE(wait_until([&] { return other.matched() > 0; }));
    say(other, false);
    ASSERT_TRUE(is_released_soon()) << i;
    ASSERT_TRUE(wait_until([&] { return reason_ != Reason::kEmergencyStop; })) << i;
  }
}

TEST_F(ArbitrationOverDds, PolicyChangesByServiceAndABadOneIsRefused) {
  ASSERT_TRUE(wait_until([&] { return v_ == 0.5; }));
  const auto client =
      node_.create_client(rt::ServiceName<tandem_msgs::srv::SetPolicy>{"/arbitration/set_policy"});
  tandem_msgs::srv::SetPolicy_Request request;
  std::string answer;
  request.policy("anarchy");
  client.call(request, [&](const auto& response) { answer = response.message(); });
  ASSERT_TRUE(wait_until([&] { return !answer.empty(); }));
  EXPECT_NE(answer.find("manual, shared, blend, adaptive, autonomous"), std::string::npos);
  EXPECT_EQ(v_, 0.5);
  request.policy("shared");
  client.call(request, [](const auto&) {});
  EXPECT_TRUE(wait_until([&] { return v_ == 0.0; }));  // no planner here
}

// Without a clock nothing ages: the person's last command would remain valid forever.
TEST_F(OneComponent, ArbitrationPassesNothingWhileSimulatedTimeStandsStill) {
  const auto arbitration = load(
      "arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}, {"use_sim_time", "true"}});
  const auto clock = node_.create_publisher(topics::clock);
  const auto user = node_.create_publisher(topics::cmd_vel_user);
  double time = 0.0, v = 0.0;
  long commands = 0;
  Reason reason = Reason::kNone;
  const auto out = node_.create_subscription(topics::cmd_vel_arbitrated, [&](const auto& msg) {
    v = std::max(v, msg.linear().x());
    ++commands;
  });
  const auto status = node_.create_subscription(
      topics::arbitration_status, [&](const auto& msg) { reason = from_msg(msg.reason_code()); });
  rt::Timer ticks = node_.create_wall_timer(0.01, [&] {
    rosgraph_msgs::msg::Clock msg;
    msg.clock(rt::to_stamp(std::llround(1e9 * (time += 0.01))));
    clock.publish(msg);
  });
  const rt::Timer push = node_.create_wall_timer(0.03, [&] {
    user.publish(to_msg(Twist2{0.5, 0.0}));
  });
  ASSERT_TRUE(wait_until([&] { return v == 0.5; }));
  ticks = {};
  ASSERT_TRUE(wait_until([&] { return reason == Reason::kClockSilent; }));
  v = 0.0;
  const long before = commands;
  ASSERT_TRUE(wait_until([&] { return commands > before + 100; }));
  EXPECT_EQ(v, 0.0);
}

// The last command would count as fresh again once the clock reaches its time.
TEST_F(OneComponent, ArbitrationPassesNothingFromBeforeTheClockJumpedBack) {
  const auto arbitration = load(
      "arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}, {"use_sim_time", "true"}});
  const auto clock = node_.create_publisher(topics::clock);
  const auto user = node_.create_publisher(topics::cmd_vel_user);
  double time = 10.0, v = 0.0;
  const auto out = node_.create_subscription(
      topics::cmd_vel_arbitrated, [&](const auto& msg) { v = std::max(v, msg.linear().x()); });
  double status_time = 0.0;
  const auto status = node_.create_subscription(topics::arbitration_status, [&](const auto& msg) {
    status_time = rt::to_seconds(msg.header().stamp());
  });
  const rt::Timer ticks = node_.create_wall_timer(0.01, [&] {
    rosgraph_msgs::msg::Clock msg;
    msg.clock(rt::to_stamp(std::llround(1e9 * (time += 0.01))));
    clock.publish(msg);
  });
  rt::Timer push = node_.create_wall_timer(0.03, [&] { user.publish(to_msg(Twist2{0.5, 0.0})); });
  ASSERT_TRUE(wait_until([&] { return v == 0.5; }));
  push = {};
  const double last = time;
  time = last - 1.0;
  ASSERT_TRUE(wait_until([&] { return status_time < last - 0.5; }));
  v = 0.0;
  ASSERT_TRUE(wait_until([&] { return status_time > last + 0.5; }));
  EXPECT_EQ(v, 0.0);
}

}  // namespace
}  // namespace tandem::test
