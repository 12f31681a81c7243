// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/local_bus.hpp"

#include <utility>

#include "tandem/runtime/detail/local_exchange.hpp"

namespace tandem::runtime {

LocalBus::LocalBus(unsigned seed, std::shared_ptr<ResultCache> cache)
    : exchange_{std::make_unique<LocalExchange>(seed)}, cache_{std::move(cache)} {}

LocalBus::~LocalBus() = default;

double LocalBus::now() const { return exchange_->events().now(); }

void LocalBus::run_for(double duration) {
  EventQueue& events = exchange_->events();
  const double end = events.now() + duration;
  while (events.run_next(end)) {
  }
}

bool LocalBus::run_until(const std::function<bool()>& done, double timeout) {
  EventQueue& events = exchange_->events();
  const double end = events.now() + timeout;
  while (!done())
    if (!events.run_next(end)) return false;
  return true;
}

void LocalBus::disturb(const std::string& topic, const LinkFaults& faults) {
  exchange_->disturb(topic, faults);
}

double LocalBus::busy(const std::string& node) const { return exchange_->busy(node); }

std::uint64_t LocalBus::delivered() const { return exchange_->delivered(); }

}  // namespace tandem::runtime
