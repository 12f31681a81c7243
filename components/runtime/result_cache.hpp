// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <typeindex>
#include <utility>
#include <vector>

namespace tandem::runtime {

/// Keeps what nodes on LocalBuses have computed, for the nodes of later buses: a study drives
/// thousands of times through the same map. Of each type, the results used last are kept. Use on
/// one thread.
class ResultCache {
 public:
  /// `max_results`: how many of each type are kept.
  explicit ResultCache(std::size_t max_results) : max_results_{max_results} {}

  /// The result of an earlier call with this key and type, otherwise that of `make()`, a
  /// std::shared_ptr<T>. The key must name everything that the result depends on.
  template <class T, class Make>
  [[nodiscard]] std::shared_ptr<T> get(const std::string& key, Make make) {
    const std::size_t hash = std::hash<std::string>{}(key);  // keys may be large and nearly equal
    const auto known = std::find_if(results_.begin(), results_.end(), [&](const Result& result) {
      return result.hash == hash && result.type == typeid(T) && result.key == key;
    });
    if (known != results_.end()) {
      std::rotate(known, known + 1, results_.end());  // the one used last is at the end
      return std::static_pointer_cast<T>(results_.back().value);
    }
    std::shared_ptr<T> made = make();
    make_room(typeid(T));
    results_.push_back(
        {typeid(T), hash, key, std::const_pointer_cast<std::remove_const_t<T>>(made)});
    return made;
  }

 private:
  void make_room(std::type_index type) {
    const auto is_of_type = [&](const Result& result) { return result.type == type; };
    const auto count = std::count_if(results_.begin(), results_.end(), is_of_type);
    if (static_cast<std::size_t>(count) >= max_results_)
      results_.erase(std::find_if(results_.begin(), results_.end(), is_of_type));
  }

  struct Result {
    std::type_index type;
    std::size_t hash;
    std::string key;
    std::shared_ptr<void> value;
  };
  std::size_t max_results_;
  std::vector<Result> results_;
};

}  // namespace tandem::runtime
