// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/event_queue.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace tandem::runtime {
namespace {

constexpr long kMaxAtOnce = 1'000'000;

class Call final : public Event {
 public:
  explicit Call(std::function<void()> fn) : fn_{std::move(fn)} {}
  void run() override { fn_(); }

 private:
  std::function<void()> fn_;
};

}  // namespace

bool EventQueue::is_later(const Entry& a, const Entry& b) {
  return std::tie(a.t, a.rank, a.number) > std::tie(b.t, b.rank, b.number);
}

void EventQueue::post_at(double t, Rank rank, std::shared_ptr<Event> event) {
  later_.push_back({std::max(t, now_), rank, ++posted_, std::move(event)});
  std::push_heap(later_.begin(), later_.end(), is_later);
}

void EventQueue::post(std::function<void()> fn) { post(std::make_shared<Call>(std::move(fn))); }

void EventQueue::post_at(double t, Rank rank, std::function<void()> fn) {
  post_at(t, rank, std::make_shared<Call>(std::move(fn)));
}

bool EventQueue::run_next(double end) {
  const auto event = take_next(end);
  if (!event) return false;
  if (++at_once_ > kMaxAtOnce)
    throw std::runtime_error("nodes on the local bus answer each other endlessly at one time");
  event->run();
  return true;
}

std::shared_ptr<Event> EventQueue::take_next(double end) {
  if (!due_.empty()) {
    auto event = std::move(due_.front());
    due_.pop_front();
    return event;
  }
  if (later_.empty() || later_.front().t > end) {
    now_ = std::max(now_, end);
    at_once_ = 0;
    return nullptr;
  }
  std::pop_heap(later_.begin(), later_.end(), is_later);
  Entry entry = std::move(later_.back());
  later_.pop_back();
  if (entry.t > now_) at_once_ = 0;
  now_ = entry.t;
  return std::move(entry.event);
}

}  // namespace tandem::runtime
