// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "tandem/arbitration/arbiter.hpp"
#include "tandem/arbitration/stop_words.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/diagnostics.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct ArbitrationNodeParams {
  ArbiterParams arbiter;
  StampParams input;
  Frames frames;
  bool start_stopped = false;

  template <class Visitor>
  void visit(Visitor&& field) {
    arbiter.visit(field);
    input.visit(field);
    frames.visit(field);
    field("start_stopped", start_stopped,
          "true: starts with an emergency stop, as if a publisher of e_stop had sent true and "
          "disappeared: e_stop must be false before the stop can be released. `respawn` in a "
          "system file sets this when arbitration is restarted");
  }
};

/// cmd_vel_user, cmd_vel_shared, cmd_vel_nav, e_stop, teleop/status, planner/status,
/// safety_filter/status, /diagnostics → cmd_vel_arbitrated, arbitration/status, /diagnostics.
///
/// Passes a command on when it arrives, repeats the command in force in between, and publishes zero
/// as soon as the source in charge is silent. Status and diagnostics report within 13 ms why the
/// robot stops, and within 25 ms why it stands, including causes in teleop, planner, safety filter
/// or a node upstream of them: when nodes wait for each other's topics, the first cause is
/// reported. Services: ~/set_policy, ~/release_emergency_stop.
class ArbitrationNode {
 public:
  using Params = ArbitrationNodeParams;

  static constexpr double kWatchdog = 0.0125;  // [s]
  static constexpr double kRepeat = 0.025;     // [s] output gap after which the command is repeated
  static constexpr double kStatusPeriod = 0.05;  // [s]

  static constexpr int kStopDepth = 100;  // messages queued while the process is stalled

  static constexpr double kReminder = 10.0;  // [s] in which a reason that alternates is logged once
  static constexpr double kTellPerformance = 0.1;  // [1] smallest change that is logged

  explicit ArbitrationNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void on_command(const Twist2& twist, Source source);
  void subscribe_emergency_stop();
  void subscribe_stop(rt::Subscription& stop, const rt::QoS& qos);
  void on_stop(const rt::PublisherId& sender, std::uint64_t sequence, bool pressed);
  void update_stop_senders();
  void offer_services();
  void decide(Source arrived);
  [[nodiscard]] bool stands_without_clock();
  void watch();
  [[nodiscard]] Causes::Cause explain();
  void say_why();
  void log_why(bool is_own);
  void publish_status();

  rt::Node& node_;
  rt::Parameters<ArbitrationNodeParams> params_;
  Arbiter arbiter_;
  Decision decision_;
  double performance_ = 1.0;  ///< last logged value
  double published_ = -1.0;   ///< time of the last command, steady time [s]
  rt::StateLog reasons_{node_.log(), kReminder};
  std::string why_;     ///< last published reason
  std::string remedy_;  ///< remedy for why_

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_arbitrated_;
  rt::Publisher<tandem_msgs::msg::ArbitrationStatus> status_;
  Diagnostics diagnostics_;
  Causes causes_;
  TwistInput user_, shared_, nav_;
  StopWords stop_words_;
  rt::Subscription stick_, planner_, filter_;
  std::array<rt::Subscription, 2> stops_;
  std::optional<rt::Subscription> latched_stop_;  // while a sender is latched
  std::shared_ptr<void> stop_publishers_;
  rt::Timer latched_left_;
  rt::Service set_policy_, release_;
  rt::Timer watchdog_, status_timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
