// SPDX-License-Identifier: Apache-2.0
// The events of a LocalBus in the order of simulated time. Private to runtime/.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

namespace tandem::runtime {

/// Something to be done at a time.
class Event {
 public:
  virtual ~Event() = default;
  virtual void run() = 0;
};

/// Runs events on simulated time.
class EventQueue {
 public:
  /// What is due at the same time is run in this order, and otherwise in the order of posting.
  enum class Rank { kMessage, kTimer };

  [[nodiscard]] double now() const { return now_; }  ///< [s]

  /// Posts an event for now, as a message.
  void post(std::shared_ptr<Event> event) { due_.push_back(std::move(event)); }
  void post(std::function<void()> fn);
  /// Posts an event for time `t` [s], or now if that is past.
  void post_at(double t, Rank rank, std::shared_ptr<Event> event);
  void post_at(double t, Rank rank, std::function<void()> fn);

  /// Runs the next event if it is due by `end` [s]; otherwise advances to `end` and returns false.
  /// Throws std::runtime_error if too many events follow each other without time passing.
  bool run_next(double end);

 private:
  struct Entry {
    double t;
    Rank rank;
    std::uint64_t number;
    std::shared_ptr<Event> event;
  };
  static bool is_later(const Entry& a, const Entry& b);
  [[nodiscard]] std::shared_ptr<Event> take_next(double end);

  double now_ = 0.0;
  long at_once_ = 0;  // events since time last advanced
  std::uint64_t posted_ = 0;
  std::deque<std::shared_ptr<Event>> due_;  // messages for now
  std::vector<Entry> later_;                // a heap, the earliest first
};

}  // namespace tandem::runtime
