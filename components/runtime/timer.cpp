// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/timer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

Beat::Beat(double start, double period) : period_{period}, start_{start} {
  if (!(period > 0.0) || !std::isfinite(period))
    throw std::invalid_argument("timer period " + std::to_string(period) + " s must be positive");
}

bool Beat::due(double now) {
  if (now < next() - (skipped_ + 1.5) * period_) {  // the clock jumped back
    start_ = now;
    ticks_ = 1.0;
    skipped_ = 0.0;
  }
  if (now < next()) {
    // Those that time has reached meanwhile no longer count.
    skipped_ = std::clamp(ticks_ - 1.0 - std::floor((now - start_) / period_), 0.0, skipped_);
    return false;
  }
  skipped_ = 0.0;
  ticks_ = std::max(ticks_ + 1.0, std::floor((now - start_) / period_));
  while (next() <= now) ticks_ += 1.0;
  return true;
}

int Beat::skip_until(double time) {
  const double first = std::ceil((time - start_) / period_);
  if (!(first > ticks_)) return 0;
  const double more = first - ticks_;
  skipped_ += more;
  ticks_ = first;
  return static_cast<int>(more);
}

void Beat::resume(double now) {
  if (skipped_ == 0.0) return;
  ticks_ = std::clamp(std::floor((now - start_) / period_) + 1.0, ticks_ - skipped_, ticks_);
  skipped_ = 0.0;
}

Timer::Timer(std::shared_ptr<NodeCore> node, std::shared_ptr<TimerState> state)
    : node_{std::move(node)}, state_{std::move(state)} {}

Timer::~Timer() { close(); }

Timer& Timer::operator=(Timer&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  state_ = std::move(other.state_);
  return *this;
}

int Timer::skip_until(double time) { return node_ ? node_->skip_until(*state_, time) : 0; }

void Timer::resume() {
  if (node_) node_->resume(*state_);
}

void Timer::close() {
  if (node_) node_->remove(*state_);
  node_.reset();
  state_.reset();
}

}  // namespace tandem::runtime
