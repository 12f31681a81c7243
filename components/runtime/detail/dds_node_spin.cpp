// SPDX-License-Identifier: Apache-2.0
// The loop of a node: waits for messages, the clock, timers and pollers, and runs what is due.
#include <algorithm>
#include <limits>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/reader_set.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

// The due items of `list`, kept alive because callbacks may change the list. Filtering here avoids
// copying pointers to the many readers and pollers that are idle most of the time.
template <class T, class Due>
std::vector<std::shared_ptr<T>> select(const std::vector<std::shared_ptr<T>>& list, Due due) {
  std::vector<std::shared_ptr<T>> selected;
  for (const auto& item : list)
    if (due(*item)) selected.push_back(item);
  return selected;
}

}  // namespace

void DdsNode::spin() {
  store.check_unknown();
  while (!stopped()) dispatch(kForever);
}

void DdsNode::spin_some(double max_wait) {
  const double end = steady_seconds() + max_wait;
  double left = max_wait;
  while (!stopped() && !dispatch(std::max(0.0, left)) && left > 0.0) left = end - steady_seconds();
}

void DdsNode::stop() {
  NodeCore::stop();
  wake_up_->notify();
}

void DdsNode::join(const std::shared_ptr<WakeUp>& group) {
  store.check_unknown();
  wake_up_->join(group);
}

double DdsNode::run_if_due() {
  if (stopped()) return kForever;
  if (wake_up_->take() || steady_seconds() >= next_.due) {
    run_due();
    next_ = time_to_next(kForever);
    const double now_steady = steady_seconds();
    next_.due += now_steady, next_.latest += now_steady;
  }
  return next_.latest;
}

bool DdsNode::dispatch(double max_wait) {
  wake_up_->wait(time_to_next(max_wait).latest);
  return run_due();
}

bool DdsNode::run_due() {
  dispatching_ = true;
  awake_ = steady_seconds();
  // The clock is read after the readers are selected, so that a message which came after a jump
  // back is delivered after the jump is reported; messages and timers then see one time.
  auto due = readers_to_drain();
  // What has waited comes first: the callbacks of what woke the node may need it.
  std::stable_partition(due.begin(), due.end(),
                        [](const auto& reader) { return reader->patience() > 0.0; });
  const bool jumped_back = read_clock();
  const bool received = run(due);
  if (more_left_)
    more_left_ = std::any_of(readers_.begin(), readers_.end(),
                             [](const auto& reader) { return reader->waiting(); });
  const bool worked = run_done();
  const bool fired = run_timers();
  run_pollers();
  dispatching_ = false;
  retired_.clear();
  return jumped_back || received || worked || fired;
}

// A node has a dozen readers or more, and often only a timer is due: they are looked at only if
// something has arrived. Something is left in those selected until they have been drained, also if
// a callback throws.
std::vector<std::shared_ptr<Reader>> DdsNode::readers_to_drain() {
  if (!any_arrived_->exchange(false) && !more_left_) return {};
  auto due = select(readers_, [](const Reader& reader) { return reader.is_due(); });
  more_left_ = !due.empty();
  return due;
}

DdsNode::Next DdsNode::time_to_next(double max_wait) const {
  if (more_left_) return {0.0, 0.0};
  const double now_steady = steady_seconds();
  Next next{max_wait, max_wait};
  const auto note = [&](double time, double slack = 0.0) {
    next.due = std::min(next.due, time - now_steady);
    next.latest = std::min(next.latest, time + slack - now_steady);
  };
  note(awake_ + patience_);
  double due = kForever;  // on /clock
  for (const auto& timer : timers_) {
    if (timer->wall || !use_sim_time)
      note(timer->beat.next(), timer->beat.slack());
    else
      due = std::min(due, timer->beat.next());
  }
  for (const auto& poller : pollers_) note(poller->next, poller->slack);
  note(peers_.due());
  if (clock_follower_ && clock_follower_->is_due(due)) return {0.0, 0.0};
  return {std::max(0.0, next.due), std::max(0.0, next.latest)};
}

bool DdsNode::run(const std::vector<std::shared_ptr<Reader>>& readers) {
  int taken = 0;
  for (const auto& reader : readers) {
    if (stopped()) break;
    taken += reader->drain();
  }
  return taken > 0;
}

// Calls what is to be done on this thread after the work of a worker.
bool DdsNode::run_done() {
  std::vector<std::shared_ptr<ThreadWorker>> done;
  std::erase_if(workers_, [&done](const auto& weak) {
    const auto worker = weak.lock();
    if (worker && worker->is_done()) done.push_back(worker);
    return !worker;
  });
  for (const auto& worker : done)
    if (!stopped()) worker->finish();
  return !done.empty();
}

bool DdsNode::run_timers() {
  const auto clock = [this](const TimerState& timer) {
    return timer.wall ? steady_seconds() : now();
  };
  const auto may_be_due = [&](const TimerState& timer) {
    return !timer.beat.is_idle(clock(timer));
  };
  bool fired = false;
  for (const auto& timer : select(timers_, may_be_due)) {
    if (stopped() || timer->closed) continue;
    if (!timer->beat.due(clock(*timer))) continue;
    timer->fn();
    fired = true;
  }
  return fired;
}

void DdsNode::run_pollers() {
  const auto is_due = [now_steady = steady_seconds()](const Poller& poller) {
    return poller.next <= now_steady;
  };
  for (const auto& poller : select(pollers_, is_due))
    if (!poller->closed) poller->next = poller->poll(steady_seconds());
  if (const double now_steady = steady_seconds(); peers_.due() <= now_steady)
    peers_.poll(now_steady);
}

}  // namespace tandem::runtime
