// SPDX-License-Identifier: Apache-2.0
// Limits the rate of HTTP answers per address. Times are seconds on one monotonic clock.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>

#include "tandem/dashboard/web/client_budget.hpp"

namespace tandem {

/// Limits files and refusals per address to 20 per second, 200 at once. Only the most recent
/// addresses are remembered.
class RequestLimit {
 public:
  static constexpr double kRate = 20.0, kBurst = 200.0;  // [Hz], at once
  static constexpr std::size_t kAddresses = 1024;

  [[nodiscard]] bool allows(const std::string& address, double now) {
    if (!records_.contains(address) && records_.size() >= kAddresses) forget_oldest();
    auto& record = records_.try_emplace(address, now).first->second;
    record.last = now;
    return record.limit.allows(now);
  }
  [[nodiscard]] std::size_t size() const { return records_.size(); }

 private:
  struct Record {
    explicit Record(double now) : limit{kRate, kBurst, now}, last{now} {}
    RateLimit limit;
    double last;
  };

  void forget_oldest() {
    records_.erase(std::min_element(
        records_.begin(), records_.end(),
        [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
  }

  std::map<std::string, Record> records_;
};

}  // namespace tandem
