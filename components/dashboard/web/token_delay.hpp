// SPDX-License-Identifier: Apache-2.0
// Makes addresses that send wrong tokens wait, against guessing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>

namespace tandem {

/// After kFree wrong tokens an address has to wait before its next attempt, 1 s at first and twice
/// as long each time, up to kLongest. Only wrong tokens are passed to this class, so a valid one is
/// never rejected. An address is forgotten kMemory after its last wrong token. Times are seconds on
/// one monotonic clock.
class TokenDelay {
 public:
  static constexpr int kFree = 5;
  static constexpr double kLongest = 60.0, kMemory = 600.0;  // [s]
  static constexpr std::size_t kAddresses = 1024;            // remembered at most

  /// Records a wrong token. Returns how long [s] the address still had to wait when it was sent; 0:
  /// it did not have to wait.
  [[nodiscard]] double wrong(const std::string& address, double now) {
    forget(now);
    Record& record = records_[address];
    const double wait = std::max(0.0, record.until - now);
    ++record.times;
    record.last = now;
    if (record.times >= kFree)
      record.until = now + std::min(kLongest, std::exp2(std::min(record.times - kFree, 10)));
    return wait;
  }

  [[nodiscard]] std::size_t size() const { return records_.size(); }

 private:
  struct Record {
    int times = 0;
    double last = 0.0, until = 0.0;
  };

  void forget(double now) {
    std::erase_if(records_, [&](const auto& r) { return now - r.second.last > kMemory; });
    if (records_.size() < kAddresses) return;
    records_.erase(std::min_element(
        records_.begin(), records_.end(),
        [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
  }

  std::map<std::string, Record> records_;
};

}  // namespace tandem
