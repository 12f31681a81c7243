// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/octomap_bytes.hpp"

#include <bit>
#include <cmath>
#include <cstring>

#include "tandem/map/detail/octree_keys.hpp"

namespace tandem {
namespace {

constexpr std::size_t kLogOdds = sizeof(float);

// Traverses the records of a tree depth first, as OctoMap writes them.
class Walk {
 public:
  explicit Walk(std::string_view data, std::size_t payload = 0) : data_{data}, payload_{payload} {}

  // Record of an inner node at `depth`: 2 bits for each of its children.
  bool binary_node(int depth) {
    if (depth >= kTreeDepth || data_.size() < 2) return false;
    const unsigned record = byte(0) | byte(1) << 8U;
    data_.remove_prefix(2);
    if (record == 0) return false;  // an inner node has at least one child
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned kind = record >> (2 * child) & 3U;
      if (kind != 0) ++nodes_;
      if (kind == 3 && !binary_node(depth + 1)) return false;
    }
    return true;
  }

  bool full_node(int depth) {
    const std::size_t record = kLogOdds + payload_ + 1;
    if (depth > kTreeDepth || data_.size() < record) return false;
    float log_odds;
    std::memcpy(&log_odds, data_.data(), sizeof log_odds);
    const unsigned children = byte(record - 1);
    data_.remove_prefix(record);
    ++nodes_;
    if (std::isnan(log_odds)) return false;
    for (int child = 0; child < std::popcount(children); ++child)
      if (!full_node(depth + 1)) return false;
    return true;
  }

  [[nodiscard]] bool at_end() const { return data_.empty(); }
  [[nodiscard]] std::size_t nodes() const { return nodes_; }

 private:
  [[nodiscard]] unsigned byte(std::size_t i) const { return static_cast<unsigned char>(data_[i]); }

  std::string_view data_;
  std::size_t payload_;
  std::size_t nodes_ = 0;
};

}  // namespace

std::optional<std::size_t> count_binary_nodes(std::string_view data) {
  Walk walk(data);
  if (!walk.binary_node(0) || !walk.at_end()) return std::nullopt;
  return walk.nodes() + 1;  // the root
}

std::optional<std::size_t> count_full_nodes(std::string_view data, std::size_t payload) {
  Walk walk(data, payload);
  if (!walk.full_node(0) || !walk.at_end()) return std::nullopt;
  return walk.nodes();
}

std::string without_payload(std::string_view data, std::size_t payload) {
  const std::size_t record = kLogOdds + payload + 1;
  std::string plain;
  plain.reserve(data.size() / record * (kLogOdds + 1));
  for (std::size_t at = 0; at + record <= data.size(); at += record)
    plain.append(data.substr(at, kLogOdds)).push_back(data[at + record - 1]);
  return plain;
}

}  // namespace tandem
