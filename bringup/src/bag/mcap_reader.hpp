// SPDX-License-Identifier: Apache-2.0
// Reads an MCAP file in order of time: with or without an index, chunks or an end.
#pragma once

#include <memory>
#include <queue>

#include "bringup/bag/bag_storage.hpp"
#include "bringup/bag/mcap_scan.hpp"

namespace tandem {

class McapReader : public BagFileReader {
 public:
  /// `name`: for messages; `file` may be removed once it is open. If its end is missing, logs so,
  /// once in a process. Throws std::runtime_error if it is damaged or holds messages that are not
  /// CDR.
  McapReader(const std::filesystem::path& file, const std::string& name);

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::int64_t first() const override;
  [[nodiscard]] bool next(BagMessage& message) override;

 private:
  // Records in memory: a decompressed chunk, or one message.
  struct Block {
    mcap::Bytes bytes;
    std::size_t messages = 0;  // that are still waiting
  };
  struct Waiting {
    std::int64_t time = 0;
    std::uint64_t order = 0;                      // of equal times
    std::size_t topic = 0, offset = 0, size = 0;  // data in the block [bytes]
    std::shared_ptr<Block> block;
    bool operator>(const Waiting& other) const {
      return time != other.time ? time > other.time : order > other.order;
    }
  };

  void add_topic(const mcap::Channel& channel);
  void load(const mcap::Place& place);
  // `place`: for messages. `offset`: of the content in the block [bytes].
  void add_message(const mcap::Place& place, const std::shared_ptr<Block>& block,
                   mcap::View content, std::size_t offset);

  mcap::File file_;
  mcap::Contents contents_;  // places in order of time
  std::vector<BagTopic> topics_;
  std::map<std::uint16_t, std::size_t> index_;  // into topics_, by channel
  std::size_t next_place_ = 0;
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting_;
  std::size_t held_ = 0;     // of all blocks [bytes]
  std::uint64_t order_ = 0;  // of the next message
};

}  // namespace tandem
