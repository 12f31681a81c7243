// SPDX-License-Identifier: Apache-2.0
// A node on DDS: its endpoints and its event loop. Private to runtime/.
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "tandem/runtime/detail/clock_source.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/detail/peer_watch.hpp"
#include "tandem/runtime/detail/thread_worker.hpp"
#include "tandem/runtime/detail/wake_up.hpp"

namespace tandem::runtime {

/// Work with deadlines on the steady clock, such as unsent replies and unanswered calls.
struct Poller {
  std::function<double(double now)> poll;  ///< runs what is due; returns when to poll next [s]
  double next = 0.0;
  double slack = 0.0;  ///< how much later [s] poll may be called if nothing else wakes the node
  bool closed = false;
};

class GuardReport;

class DdsNode final : public NodeCore {
 public:
  explicit DdsNode(NodeOptions node_options);
  ~DdsNode() override;

  [[nodiscard]] std::shared_ptr<PublisherPort> open_publisher(const std::string& topic,
                                                              TypeRef type,
                                                              const QoS& qos) override;
  [[nodiscard]] std::shared_ptr<PublisherPort> open_generic_publisher(
      const std::string& topic, const std::string& type, const QoS& qos,
      const std::string& type_hash) override;
  [[nodiscard]] std::shared_ptr<SubscriptionPort> open_subscription(const std::string& topic,
                                                                    const QoS& qos,
                                                                    Receiver receiver,
                                                                    Accepts accepts) override;
  [[nodiscard]] std::shared_ptr<SubscriptionPort> open_generic_subscription(
      const std::string& topic, const std::string& type, const QoS& qos,
      std::function<void(const std::vector<std::uint8_t>&)> fn) override;
  [[nodiscard]] std::shared_ptr<ServicePort> open_service(
      const std::string& service, Responder responder, const QoS& qos,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<ClientPort> open_client(
      const std::string& service, TypeRef request, TypeRef response,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<ClientPort> open_generic_client(
      const std::string& service, const std::string& type,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<WorkerPort> open_worker(Worker::Work work,
                                                        Worker::Done done) override;
  [[nodiscard]] std::shared_ptr<void> watch_publishers(const std::string& topic, TypeRef type,
                                                       PublishersChanged fn) override;
  void add(std::shared_ptr<TimerState> timer) override { timers_.push_back(std::move(timer)); }
  void remove(TimerState& timer) override;
  int skip_until(TimerState& timer, double time) override { return timer.beat.skip_until(time); }
  void resume(TimerState& timer) override;
  void retire(std::shared_ptr<void> part) override;

  [[nodiscard]] bool is_present(const PublisherId& publisher) const override;
  [[nodiscard]] std::size_t count_publishers(const std::string& topic) const override;
  [[nodiscard]] std::vector<TopicInfo> topics() const override;
  [[nodiscard]] std::vector<ServiceInfo> services() const override;

  [[nodiscard]] double steady_now() const override;
  [[nodiscard]] std::int64_t system_nanoseconds() const override;
  void spin() override;
  void spin_some(double max_wait) override;

  /// For a thread that spins several nodes, instead of spin(): from now on what wakes this node
  /// wakes `group`. Throws as spin() for a parameter that was not declared.
  void join(const std::shared_ptr<WakeUp>& group);
  /// Runs what is due, without waiting, on that thread. Returns the time [s, steady clock] at which
  /// to call it again if nothing wakes the group earlier; infinity once it is stopped.
  double run_if_due();
  void stop() override;

  std::shared_ptr<Writer> open_writer(const Endpoint& endpoint);
  /// Without `deliver_sample`, the messages of this process come through DDS, too.
  std::shared_ptr<Reader> open_reader(const Endpoint& endpoint, Reader::Deliver deliver,
                                      Reader::DeliverSample deliver_sample = {});
  void close_writer(Writer& writer);
  void close_reader(Reader& reader);
  void add(std::shared_ptr<Poller> poller) { pollers_.push_back(std::move(poller)); }
  void remove(Poller& poller);

  /// Call after a reader's patience has changed.
  void update_patience();

  [[nodiscard]] PeerWatch& peers() { return peers_; }
  [[nodiscard]] const Discovery& discovery() const { return participant_->discovery(); }
  /// The domain's id.
  [[nodiscard]] int domain() const { return participant_->domain(); }
  /// Whether the endpoint belongs to this process.
  [[nodiscard]] bool is_own(const rtps::GUID_t& guid) const { return participant_->is_own(guid); }

 private:
  // When a timer or poller is due, and when it must run if nothing else wakes the node earlier [s].
  struct Next {
    double due = 0.0, latest = 0.0;
  };

  std::shared_ptr<PublisherPort> open_publisher(const Endpoint& endpoint, TypeRef type,
                                                std::shared_ptr<Codec> codec);
  void open_clock(const std::string& topic, const QoS& qos) override;
  void close_clock() override;
  bool read_clock();  // true if it jumped back
  void know(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes);
  void forget(const rtps::GUID_t& guid);
  bool dispatch(double max_wait);  // true if a message was taken or a timer ran
  bool run_due();                  // the same without waiting
  [[nodiscard]] std::vector<std::shared_ptr<Reader>> readers_to_drain();
  [[nodiscard]] Next time_to_next(double max_wait) const;  // from now on
  bool run(const std::vector<std::shared_ptr<Reader>>& readers);
  bool run_done();
  bool run_timers();
  void run_pollers();

  std::shared_ptr<Participant> participant_;
  std::shared_ptr<WakeUp> wake_up_ = std::make_shared<WakeUp>();
  PeerWatch peers_;
  std::shared_ptr<Poller> guard_poller_ = std::make_shared<Poller>();
  std::vector<std::shared_ptr<Reader>> readers_;
  std::shared_ptr<std::atomic<bool>> any_arrived_ = std::make_shared<std::atomic<bool>>();
  bool more_left_ = false;  // whether a reader may hold more: it is new, or had more than a batch
  double patience_ = std::numeric_limits<double>::infinity();  // the readers' least [s]
  std::unique_ptr<ClockFollower> clock_follower_;              // under use_sim_time
  std::vector<std::shared_ptr<TimerState>> timers_;
  std::vector<std::shared_ptr<Poller>> pollers_;
  std::vector<std::weak_ptr<ThreadWorker>> workers_;
  std::vector<std::shared_ptr<void>> retired_;
  bool dispatching_ = false;
  double awake_ = 0.0;  // when the node was last awake [s], steady clock
  Next next_;           // on the steady clock; for run_if_due()
  std::unique_ptr<GuardReport> guard_report_;
};

}  // namespace tandem::runtime
