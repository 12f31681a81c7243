// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "tandem/dashboard/autonomy_guard.hpp"
#include "tandem/dashboard/bridge/parameter_relay.hpp"
#include "tandem/dashboard/bridge/publish_relay.hpp"
#include "tandem/dashboard/bridge/service_relay.hpp"
#include "tandem/dashboard/bridge/topic_relay.hpp"
#include "tandem/dashboard/driver_lock.hpp"
#include "tandem/dashboard/user_study/trial_recorder.hpp"
#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct DashboardParams {
  WebServerParams web;
  double seat_timeout = 5.0;
  double max_age = 0.5;
  std::string user_tests = "out/user_tests";
  RobotStateParams input;

  template <class Visitor>
  void visit(Visitor&& field) {
    web.visit(field);
    field("seat_timeout", seat_timeout, Range{0.2, 3600.0},
          "[s] a driver that has sent nothing for this long loses the driver lock");
    field("max_age", max_age, Range{0.0, 60.0},
          "[s] a client's joy with an older stamp is ignored; 0: no limit");
    field("user_tests", user_tests, "folder for the results of the page's user test");
    input.visit(field);
  }
};

/// Every topic and service of the domain → web clients (Foxglove, Lichtblick, the page that this
/// node serves); joy, cmd_vel_user, goal_pose, initialpose, end_sim, e_stop ← web clients.
///
/// One client drives at a time; to drive while another client does, a client must take over
/// explicitly. Every client may press the emergency stop.
class DashboardNode {
 public:
  using Params = DashboardParams;

  static constexpr double kTick = 0.005;  // [s] between two ticks, which handle the clients' events
  static constexpr double kIdleTick = 0.1;      // [s] the same while no client is connected
  static constexpr double kUsual = 0.0015;      // [s] of a tick for frames of connected clients
  static constexpr double kLastWords = 0.0005;  // [s] of a tick for frames of clients that left
  static constexpr int kMaxUrgent = 64;         // emergency stop messages handled per tick
  static constexpr double kPollPeriod = 0.5;    // [s] between two looks at the domain
  static constexpr double kTimePeriod = 0.05;   // [s]
  static constexpr double kSavePeriod = 1.0;    // [s] minimum interval of two saved user tests
  static constexpr double kTrialPeriod = 0.3;   // [s] minimum interval of two trial starts

  explicit DashboardNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void start_ticks();
  void tick();
  void look();
  void look_at_domain();
  bool serve(Lane lane);
  void serve_for(double time, Lane lane);
  void on_event(const WebEvent& event);
  void on_join(ClientId client);
  void on_leave(ClientId client);
  void tell_time(ClientId client);
  void on_advertise(ClientId client, const foxglove::Advertise& request);
  void on_message(ClientId client, const foxglove::Message& message);
  void on_call(ClientId client, const foxglove::ServiceCall& call);
  void on_set(ClientId client, const foxglove::SetParameters& request);
  [[nodiscard]] std_srvs::srv::Trigger::Response take_wheel(ClientId client);
  void tell_seat();
  void tell_trial();
  void tell_trial(const std::string& state);
  [[nodiscard]] PublishRelay::Outcome begin_trial(ClientId client,
                                                  const std::vector<std::uint8_t>& bytes);
  [[nodiscard]] PublishRelay::Outcome save_user_test(ClientId client,
                                                     const std::vector<std::uint8_t>& bytes);
  void complain(ClientId client, const std::string& what);

  rt::Node& node_;
  rt::Parameters<DashboardParams> params_;
  WebServer web_;
  TopicRelay topics_;
  ServiceRelay services_;
  ParameterRelay parameters_;
  PublishRelay publish_;
  DriverLock driver_lock_;
  AutonomyGuard autonomy_;
  double saved_ = -kSavePeriod;           // [s] when a user test was last saved
  double trial_began_ = -kTrialPeriod;    // [s] when a trial last began
  std::unique_ptr<TrialRecorder> trial_;  // the trial in progress
  std::string came_to_;  // result of the last trial, repeated until the next begins
  std::set<ClientId> clients_;
  std::string told_;                    // the driver state last reported
  std::map<ClientId, double> refused_;  // [s] when a refusal was last reported to them

  bool is_idle_ = true;  // no client and no trial
  rt::Timer ticks_, looks_;
  rt::Timer time_;  // unless is_idle_
};

}  // namespace tandem
