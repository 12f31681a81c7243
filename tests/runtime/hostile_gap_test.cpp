// SPDX-License-Identifier: Apache-2.0
// Sends datagrams with the GUID of a writer that is matched with a reader of another process.
#include <gtest/gtest.h>

#include "runtime/datagram.hpp"
#include "support/child_process.hpp"
#include "support/memory_of.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "support/udp_sender.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using test::Datagram;
using test::Octets;

constexpr double kAnswerTimeout = 20.0;                    // [s]
constexpr double kMaxGapMemory = test::most_memory(20.0);  // [MB]

// `peer echo` subscribes to /ping reliably and answers on /pong.
class ForgedWriter : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(test::spin_until([&] { return writer_.matched() == 1 && pong_.matched() == 1; },
                                 kAnswerTimeout, node_));
    ASSERT_TRUE(answers());
  }
  [[nodiscard]] bool answers() {
    const int before = answers_;
    rt::Bytes bytes;
    const Twist message;
    (void)codec_.encode(&message, bytes);
    (void)writer_.write(bytes);
    return test::spin_until([&] { return answers_ > before; }, kAnswerTimeout, node_);
  }
  // From our writer, to all participants.
  [[nodiscard]] Datagram forged() const {
    const auto guid = writer_.guid();
    return std::move(Datagram{}.prefix({guid.guidPrefix.value, guid.guidPrefix.value + 12}));
  }
  [[nodiscard]] std::uint32_t entity() const {
    const auto& value = writer_.guid().entityId.value;
    return std::uint32_t{value[0]} << 24 | std::uint32_t{value[1]} << 16 |
           std::uint32_t{value[2]} << 8 | value[3];
  }
  void send(const Datagram& datagram) const { sender_.send_to_all(datagram.octets(), 8); }
  [[nodiscard]] double memory() const { return test::memory_of(peer_.pid()); }

  test::ChildProcess peer_{"peer", {"echo"}};
  rt::Node node_{"pinger"};
  rt::Codec codec_{rt::type_ref<Twist>()};
  rt::Writer writer_{*rt::Participant::shared(), {"rt/ping", codec_.dds_name(), rt::kDefault}};
  int answers_ = 0;
  rt::Subscription pong_ = node_.create_subscription(rt::Topic<Twist>{"pong", rt::kLatched},
                                                     [this](const auto&) { ++answers_; });
  test::UdpSender sender_;
};

// CVE-2025-64438: without the guard, each number of the gap takes 48 bytes.
TEST_F(ForgedWriter, FillsNoMemoryByWideGaps) {
  const double before = memory();
  for (const std::int64_t start : {3, 1000, 1'000'000})
    for (int i = 0; i < 3; ++i) send(forged().add_gap(start, start + 20'000'000, 0, 0, entity()));
  EXPECT_FALSE(test::spin_until([&] { return memory() > before + kMaxGapMemory; }, 1.0, node_));
  EXPECT_EQ(peer_.wait(0.0), std::nullopt);
}

TEST_F(ForgedWriter, FillsNoMemoryByManyGapsAndNumbers) {
  const double before = memory();
  for (std::int64_t i = 0; i < 20'000; ++i) {
    send(forged().add_gap(1000 + 1000 * i, 1256 + 1000 * i, 256, 0, entity()));
    send(forged().add_data({.writer = entity(), .number = 5'000'000 + 2 * i}, Octets(8, 1)));
    if (i % 100 == 0) node_.spin_some(0.001);
  }
  EXPECT_LT(memory(), before + kMaxGapMemory);
  EXPECT_TRUE(answers());  // none of it was of numbers that the writer reaches soon
}

}  // namespace
}  // namespace tandem
