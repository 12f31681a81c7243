// SPDX-License-Identifier: Apache-2.0
// Sends samples far larger than their topic allows: the receiving process must not keep the memory.
#include <gtest/gtest.h>

#include <cstring>

#include "support/child_process.hpp"
#include "support/memory_of.hpp"
#include "support/private_domain.hpp"
#include "support/secured_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/cdr_structure.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using rt::Bytes;

constexpr double kTimeout = 30.0;                     // [s]
constexpr double kMaxKept = test::most_memory(20.0);  // [MB]
constexpr std::size_t kMega = 1'000'000;

struct Open {};
struct Secured {
  test::SecuredDomain domain;
  test::Variables enclave{{{"ROS_SECURITY_ENCLAVE_OVERRIDE", "/watcher"}}};
};

template <class Where>
class MemoryIn : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(test::spin_until([&] { return pong_.matched() == 1; }, kTimeout, node_));
  }

  // Sends `bad` `times` times, and after each a valid message from another writer, which is
  // answered.
  template <class M>
  void attack(const char* topic, const Bytes& bad, int times) {
    const auto participant = rt::Participant::shared();
    const rt::Codec codec{rt::type_ref<M>()};
    const rt::Endpoint endpoint{topic, codec.dds_name(), rt::kDefault};
    rt::Writer stranger{*participant, endpoint}, friendly{*participant, endpoint};
    ASSERT_TRUE(test::spin_until([&] { return stranger.matched() + friendly.matched() == 2; },
                                 kTimeout, node_));
    Bytes good;
    ASSERT_TRUE(codec.encode(std::make_unique<M>().get(), good));
    const auto answered = [&] {
      const int before = answers_;
      (void)friendly.write(good);
      return test::spin_until([&] { return answers_ > before; }, kTimeout, node_);
    };
    ASSERT_TRUE(answered());
    const double before = memory();
    for (int i = 0; i < times; ++i) {
      (void)stranger.write(bad);
      ASSERT_TRUE(answered());
    }
    EXPECT_TRUE(test::spin_until([&] { return memory() < before + kMaxKept; }, 5.0, node_))
        << memory() - before << " MB are kept";
  }
  [[nodiscard]] double memory() const { return test::memory_of(peer_.pid()); }
  [[nodiscard]] double peak() const { return test::memory_of(peer_.pid(), "VmHWM"); }

 private:
  Where where_;
  test::ChildProcess peer_{"peer", {"listen"}};
  rt::Node node_{"stranger"};
  int answers_ = 0;
  rt::Subscription pong_ =
      node_.create_subscription(rt::Topic<geometry_msgs::msg::Twist>{"pong", rt::kLatched},
                                [this](const auto&) { ++answers_; });
};

class HostileMemory : public MemoryIn<Open> {};
class SecuredMemory : public MemoryIn<Secured> {};

TEST_F(HostileMemory, OfThreeSamplesOf60MegabytesOnOdomIsNotKept) {
  attack<nav_msgs::msg::Odometry>("rt/odom", Bytes(60 * kMega, 1), 3);
  EXPECT_LT(peak(), test::most_memory(100.0));
}

TEST_F(HostileMemory, OfTwoSamplesOf300MegabytesOnJoyIsNotKept) {
  attack<sensor_msgs::msg::Joy>("rt/joy", Bytes(300 * kMega, 1), 2);
  EXPECT_LT(peak(), test::most_memory(100.0));
}

// The guard cannot read how large an encrypted sample is; the reader's history can.
TEST_F(SecuredMemory, OfThreeSamplesOf60MegabytesOnOdomIsNotKept) {
  attack<nav_msgs::msg::Odometry>("rt/odom", Bytes(60 * kMega, 1), 3);
  EXPECT_LT(peak(), test::most_memory(100.0));
}

TEST_F(SecuredMemory, OfTwoSamplesOf300MegabytesOnJoyIsNotKept) {
  attack<sensor_msgs::msg::Joy>("rt/joy", Bytes(300 * kMega, 1), 2);
  EXPECT_LT(peak(), test::most_memory(100.0));
}

// Its `fields` claim one element for each byte that is left.
TEST_F(HostileMemory, IsNotAllocatedForAPointCloudThatClaimsMoreFieldsThanItHas) {
  Bytes cloud(60 * kMega, 0);
  cloud[1] = 1;  // little endian
  const std::uint32_t claimed = 59'000'000;
  std::memcpy(cloud.data() + 4 + 24, &claimed, sizeof claimed);  // stamp, "", height, width: before
  attack<sensor_msgs::msg::PointCloud2>("rt/points", cloud, 2);
  EXPECT_LT(peak(), test::most_memory(300.0));  // the sample itself, in the history and taken
}

// --- what the bytes can be
// ------------------------------------------------------------------------

template <class M>
const rt::CdrStructure& structure() {
  return *rt::CdrStructure::of(rt::type_ref<M>().name);
}

TEST(CdrStructure, FitsEveryEncodedMessage) {
  const auto fits = [](const auto& message) {
    using M = std::decay_t<decltype(message)>;
    Bytes bytes;
    EXPECT_TRUE(rt::Codec{rt::type_ref<M>()}.encode(&message, bytes));
    return structure<M>().fits(bytes);
  };
  EXPECT_TRUE(fits(nav_msgs::msg::Odometry{}));
  EXPECT_TRUE(fits(std_msgs::msg::Bool{}));
  sensor_msgs::msg::PointCloud2 cloud;
  cloud.fields().resize(3);
  cloud.fields()[1].name("intensity");
  cloud.data().assign(1001, 7);
  EXPECT_TRUE(fits(cloud));
  visualization_msgs::msg::MarkerArray markers;
  markers.markers().resize(3);
  markers.markers()[1].points().resize(5);
  markers.markers()[2].ns("a");
  EXPECT_TRUE(fits(markers));
  diagnostic_msgs::msg::DiagnosticArray diagnostics;
  diagnostics.status().resize(2);
  diagnostics.status()[0].values().resize(3);
  EXPECT_TRUE(fits(diagnostics));
}

TEST(CdrStructure, DoesNotFitCountsBeyondTheBytes) {
  visualization_msgs::msg::MarkerArray markers;
  markers.markers().resize(1);
  Bytes bytes;
  ASSERT_TRUE(
      rt::Codec{rt::type_ref<visualization_msgs::msg::MarkerArray>()}.encode(&markers, bytes));
  for (const std::uint32_t count : {2U, 1000U, 0x7fffffffU, 0xffffffffU}) {
    std::memcpy(bytes.data() + 4, &count, sizeof count);
    EXPECT_FALSE(structure<visualization_msgs::msg::MarkerArray>().fits(bytes)) << count;
  }
}

TEST(CdrStructure, KnowsTheLargestMessageOfATypeThatHasOne) {
  EXPECT_GE(structure<geometry_msgs::msg::Twist>().largest().value_or(0), 4 + 48u);
  EXPECT_LT(structure<geometry_msgs::msg::Twist>().largest().value_or(1000), 150u);
  EXPECT_FALSE(structure<nav_msgs::msg::Odometry>().largest());
  EXPECT_EQ(rt::CdrStructure::of("other_msgs/msg/Thing"), nullptr);
}

}  // namespace
}  // namespace tandem
