// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/connection_pool.hpp"

#include <algorithm>

namespace tandem {

ConnectionPool::Id ConnectionPool::admit(const std::string& address) {
  waiting_[++last_] = address;
  return last_;
}

void ConnectionPool::set_address(Id connection, const std::string& address) {
  if (const auto found = waiting_.find(connection); found != waiting_.end())
    found->second = address;
}

std::optional<ConnectionPool::Id> ConnectionPool::evict() {
  std::map<std::string, std::size_t> counts;
  std::size_t most = 0;
  for (const auto& [id, address] : waiting_) most = std::max(most, ++counts[address]);
  const bool full = waiting_.size() > limits_.all;
  const auto oldest = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& entry) {
    const std::size_t count = counts[entry.second];
    return (full && count == most) || (!entry.second.empty() && count > limits_.per_address);
  });
  if (oldest == waiting_.end()) return std::nullopt;
  const Id id = oldest->first;
  waiting_.erase(oldest);
  return id;
}

}  // namespace tandem
