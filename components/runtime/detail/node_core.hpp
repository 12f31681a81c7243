// SPDX-License-Identifier: Apache-2.0
// Holds a node's state and event loop, shared by its handles so that they may outlive the Node.
// Private to runtime/.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/detail/peer_watch.hpp"
#include "tandem/runtime/detail/qos_overrides.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::runtime {

/// Parameters that every node has, as in rclcpp.
inline constexpr const char* kUseSimTime = "use_sim_time";
inline constexpr const char* kTypeDescriptionService = "start_type_description_service";

/// Period, function and clock of a Timer.
struct TimerState {
  Beat beat;
  std::function<void()> fn;
  bool wall;  ///< uses steady time even under use_sim_time
  bool closed = false;
};

/// Work with deadlines on the steady clock, such as unsent replies and unanswered calls.
struct Poller {
  std::function<double(double now)> poll;  ///< runs what is due; returns when to poll next [s]
  double next = 0.0;
  bool closed = false;
};

class GuardReport;
class NodeServices;

class NodeCore {
 public:
  explicit NodeCore(NodeOptions node_options);
  ~NodeCore();
  NodeCore(const NodeCore&) = delete;
  NodeCore& operator=(const NodeCore&) = delete;

  std::shared_ptr<Writer> open_writer(const Endpoint& endpoint);
  std::shared_ptr<Reader> open_reader(const Endpoint& endpoint, Reader::Deliver deliver);
  void close_writer(Writer& writer);
  void close_reader(Reader& reader);
  void add(std::shared_ptr<TimerState> timer) { timers_.push_back(std::move(timer)); }
  void remove(TimerState& timer);
  void add(std::shared_ptr<Poller> poller) { pollers_.push_back(std::move(poller)); }
  void remove(Poller& poller);

  [[nodiscard]] PeerWatch& peers() { return peers_; }
  [[nodiscard]] const Discovery& discovery() const { return participant_->discovery(); }
  /// Whether the endpoint belongs to this process.
  [[nodiscard]] bool is_own(const rtps::GUID_t& guid) const { return participant_->is_own(guid); }

  /// Keeps `part` alive until the running callbacks return: a callback may close its own caller.
  void retire(std::shared_ptr<void> part);

  [[nodiscard]] std::string resolve(const char* topic) const;
  [[nodiscard]] double now() const;
  [[nodiscard]] bool clock_is_silent() const;
  [[nodiscard]] std::shared_ptr<void> on_time_jump(std::function<void()> fn);
  [[nodiscard]] builtin_interfaces::msg::Time stamp() const;

  void spin();
  void spin_some(double max_wait);
  void stop();
  [[nodiscard]] bool stopped() const { return stopped_; }

  const NodeOptions options;
  const NodeName name;
  const std::string full_name;
  Logger log;
  ParameterStore store;
  ParameterTable parameters;
  QosOverrides qos_overrides{store, parameters};
  bool use_sim_time;
  bool serves_type_descriptions = true;

 private:
  void declare_common();
  void set_use_sim_time(bool wanted);
  void report_time_jump();
  void follow_clock();
  void set_clock(const builtin_interfaces::msg::Time& time);
  void know(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes);
  void forget(const rtps::GUID_t& guid);
  bool dispatch(double max_wait);  // true if a message was taken or a timer ran
  [[nodiscard]] double time_to_next(double max_wait) const;
  bool run_readers();
  bool run_timers();
  void run_pollers();

  std::shared_ptr<Participant> participant_;
  PeerWatch peers_;
  std::shared_ptr<Poller> peer_poller_ = std::make_shared<Poller>();
  std::shared_ptr<Poller> guard_poller_ = std::make_shared<Poller>();
  fdds::WaitSet wait_set_;
  fdds::GuardCondition wake_up_;
  fdds::ConditionSeq active_;  // reused to avoid allocation
  std::vector<std::shared_ptr<Reader>> readers_;
  std::vector<std::shared_ptr<TimerState>> timers_;
  std::vector<std::shared_ptr<Poller>> pollers_;
  std::vector<std::shared_ptr<void>> retired_;
  bool dispatching_ = false;
  std::shared_ptr<Reader> clock_reader_;
  std::vector<std::weak_ptr<std::function<void()>>> time_jumps_;  // called when the time jumps
  std::unique_ptr<NodeServices> services_;
  std::unique_ptr<GuardReport> guard_report_;
  std::atomic<std::int64_t> clock_ = 0;  // last time received on /clock [ns]
  std::atomic<double> clock_arrival_;    // its arrival [s], steady clock
  std::atomic<bool> stopped_ = false;
};

}  // namespace tandem::runtime
