// SPDX-License-Identifier: Apache-2.0
// Receives simulated time once for all nodes of the process. Private to runtime/.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class ClockFollower;

/// The reader of one clock topic, which nodes follow by a ClockFollower. A message costs one sample
/// and wakes only the nodes that wait for its time. Thread-safe.
class TANDEM_EXPORT_FOR_TESTS ClockSource {
 public:
  ClockSource(Participant& participant, Endpoint endpoint);
  ~ClockSource();
  ClockSource(const ClockSource&) = delete;
  ClockSource& operator=(const ClockSource&) = delete;

  [[nodiscard]] bool reads(const Endpoint& endpoint) const {
    return endpoint.topic == endpoint_.topic && endpoint.qos == endpoint_.qos;
  }
  [[nodiscard]] const Reader& reader() const { return reader_; }

 private:
  friend class ClockFollower;
  void receive(std::int64_t time);
  void refuse(const std::string& what);

  Participant& participant_;
  const Endpoint endpoint_;
  std::mutex receiving_;   // one sample of DDS at a time
  std::mutex mutex_;       // guards what follows, up to reader_
  std::int64_t time_ = 0;  // last received [ns]
  double arrival_ = 0.0;   // of that time [s], steady clock
  long jumps_ = 0;         // how often the time jumped back
  std::string refused_;    // why a sample was dropped, until a follower reads it
  std::vector<ClockFollower*> followers_;
  Reader reader_;  // last, because it calls the functions above until it is destroyed
};

/// The clock as one node reads it. All functions are called on the node's thread.
class TANDEM_EXPORT_FOR_TESTS ClockFollower {
 public:
  /// What was received so far.
  struct Reading {
    std::int64_t time = 0;     ///< last received [ns]; 0 before the first
    double arrival = 0.0;      ///< of that time [s], steady clock
    bool jumped_back = false;  ///< since the follower's last reading
    std::string refused;       ///< why a sample was dropped since then; told to one follower only
  };

  /// `wake` is called on the thread that brings a sample, and must not call the follower.
  ClockFollower(std::shared_ptr<ClockSource> source, std::function<void()> wake);
  ~ClockFollower();
  ClockFollower(const ClockFollower&) = delete;
  ClockFollower& operator=(const ClockFollower&) = delete;

  [[nodiscard]] const Reader& reader() const { return source_->reader(); }
  [[nodiscard]] Reading read();
  /// Has the node woken once the time reaches `due` [s], or there is something else to read.
  /// Returns true, and wakes nobody, if that is so already.
  [[nodiscard]] bool is_due(double due);

 private:
  friend class ClockSource;
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool has_news(double due) const;  // with the source's mutex held
  void wake_if_due();                             // with the source's mutex held

  std::shared_ptr<ClockSource> source_;
  std::function<void()> wake_;
  double due_ = kNever;  // guarded by the source's mutex, like the following
  bool is_waiting_ = false;
  long jumps_seen_ = 0;
};

}  // namespace tandem::runtime
