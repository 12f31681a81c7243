// SPDX-License-Identifier: Apache-2.0
// Runs nodes in one thread on simulated time, without DDS: for studies and unit tests.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class LocalExchange;
class ResultCache;

/// How the messages of a topic travel on a LocalBus. The default is at once, and all of them.
struct LinkFaults {
  double delay = 0.0;   ///< [s] of every message
  double jitter = 0.0;  ///< [s] further delay, uniformly distributed from 0 to this
  double loss = 0.0;    ///< [1] probability that a message is lost on its way to a subscription;
                        ///< 1: silence, also on a reliable topic
};

/// A bus inside the process. Nodes whose NodeOptions name it exchange messages, services and
/// actions with each other only; component code is the same as over DDS. A drive of
/// the same nodes is the same bit for bit on one machine, whatever else it does.
///
/// * Time is simulated: it advances to the next event when nothing is left to do. Callbacks take
///   none. Node::steady_now() is the bus's time; under `use_sim_time` a node's clock is /clock,
///   which some node on the bus has to publish. System time begins at 2001-09-09 01:46:40 UTC.
/// * Messages are delivered in the order in which they were published, by pointer and not
///   serialized. Depth, durability, lifespan and compatibility of QoS apply.
/// * Of what is due at one time, messages come first. Then timers fire one at a time, in the order
///   in which they became due, and what each publishes is delivered before the next one.
/// * Workers (Node::create_worker) do their work within the same instant.
///
/// Everything, the nodes included, is to be used on one thread.
class TANDEM_EXPORT LocalBus {
 public:
  static constexpr double kResend = 0.1;  ///< [s] until a lost message of a reliable topic arrives

  /// `seed`: of the faults of links. `cache`: shared with other buses, see Node::cached(); may be
  /// null.
  explicit LocalBus(unsigned seed = 1, std::shared_ptr<ResultCache> cache = {});
  ~LocalBus();
  LocalBus(const LocalBus&) = delete;
  LocalBus& operator=(const LocalBus&) = delete;

  /// Simulated time [s] since the bus was made.
  [[nodiscard]] double now() const;

  /// Runs the callbacks that are due within the next `duration` [s]. Passes on what they throw;
  /// throws std::runtime_error if nodes answer each other endlessly without time passing.
  void run_for(double duration);
  /// Runs callbacks until `done()`, which is evaluated after each of them, for at most `timeout`
  /// [s]. Returns whether it is done. Throws as run_for().
  bool run_until(const std::function<bool()>& done, double timeout);

  /// Messages that are published on the topic from now on (full name; empty: on every topic
  /// without faults of its own) travel like that. A lost message of a reliable topic arrives
  /// kResend later, and those behind it wait; a best-effort one that another has overtaken is
  /// lost. Throws std::invalid_argument for a negative time or a loss outside [0, 1].
  void disturb(const std::string& topic, const LinkFaults& faults);

  /// Number of messages delivered so far.
  [[nodiscard]] std::uint64_t delivered() const;

  /// Time [s] that the callbacks of a node (full name) and its workers have taken so far, by the
  /// machine's steady clock.
  [[nodiscard]] double busy(const std::string& node) const;

  /// The cache that it was made with.
  [[nodiscard]] const std::shared_ptr<ResultCache>& cache() const { return cache_; }

  /// For the runtime itself.
  [[nodiscard]] LocalExchange& exchange() { return *exchange_; }

 private:
  std::unique_ptr<LocalExchange> exchange_;
  std::shared_ptr<ResultCache> cache_;
};

}  // namespace tandem::runtime

namespace tandem {
namespace rt = runtime;
}
