// SPDX-License-Identifier: Apache-2.0
// When Tandem publishes what ROS 2 tools read about its nodes.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/child_process.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using test::ChildProcess;
using test::kTimeout;
using test::spin_until;

// The samples of ros_discovery_info, each as the number of endpoints of each node.
class EverySample {
 public:
  using Sizes = std::vector<std::size_t>;

  EverySample(rt::Participant& participant, rt::Durability durability)
      : reader_{participant,
                {"ros_discovery_info", codec_.dds_name(), {.durability = durability, .depth = 100}},
                [this](const rt::Bytes& bytes, const auto&) { return note(bytes); },
                {[](std::size_t) {}, [] {}}} {}

  /// Of the participants that `is_wanted` takes by their ids, in their order.
  template <class Predicate>
  std::vector<Sizes> of(Predicate is_wanted) {
    reader_.drain();
    std::vector<Sizes> wanted;
    for (const auto& [gid, sizes] : samples_)
      if (is_wanted(gid)) wanted.push_back(sizes);
    return wanted;
  }
  /// How many participants publish samples.
  [[nodiscard]] int writers() const { return reader_.matched(); }

 private:
  bool note(const rt::Bytes& bytes) {
    rmw_dds_common::msg::ParticipantEntitiesInfo info;
    EXPECT_TRUE(codec_.decode(bytes, &info));
    Sizes sizes;
    for (const auto& node : info.node_entities_info_seq())
      sizes.push_back(node.writer_gid_seq().size() + node.reader_gid_seq().size());
    samples_.emplace_back(info.gid(), std::move(sizes));
    return true;
  }

  rt::Codec codec_{rt::type_ref<rmw_dds_common::msg::ParticipantEntitiesInfo>()};
  std::vector<std::pair<rmw_dds_common::msg::Gid, Sizes>> samples_;
  rt::Reader reader_;
};

class GraphChanges : public testing::Test {
 protected:
  using Samples = std::vector<EverySample::Sizes>;

  void SetUp() override {
    ASSERT_TRUE(spin_until([&] { return samples_.writers() == 1; }, kTimeout, node_));
  }
  [[nodiscard]] bool is_own(const rmw_dds_common::msg::Gid& gid) const {
    const auto& prefix = participant_->dds().guid().guidPrefix.value;
    return std::equal(prefix, prefix + 12, gid.data().begin());
  }
  // Once there are `count`.
  Samples own(std::size_t count) {
    Samples own;
    const auto are_there = [&] {
      own = samples_.of([&](const auto& gid) { return is_own(gid); });
      return own.size() >= count;
    };
    EXPECT_TRUE(spin_until(are_there, kTimeout, node_));
    return own;
  }
  auto publisher() { return node_.create_publisher(rt::Topic<std_msgs::msg::Bool>{"a"}); }

  rt::Node node_{rt::NodeOptions{.name = "seen", .serves_tools = false}};
  std::shared_ptr<rt::Participant> participant_ = rt::Participant::shared();
  EverySample samples_{*participant_, rt::Durability::kVolatile};  // none of before
};

TEST_F(GraphChanges, ReportsABatchInOneSample) {
  const auto first = publisher();
  std::vector<rt::Publisher<std_msgs::msg::Bool>> publishers;
  {
    const rt::Graph::Batch outer{participant_->graph()}, inner{participant_->graph()};
    publishers.push_back(publisher());
    publishers.push_back(publisher());
  }
  publishers.push_back(publisher());
  EXPECT_EQ(own(3), (Samples{{1}, {3}, {4}}));
}

// DDS discovery reports it by itself, and tools pass over what it does not know.
TEST_F(GraphChanges, ReportsTheEndOfAnEndpointWithTheNextChange) {
  { const auto brief = publisher(); }
  const auto lasting = publisher();
  EXPECT_EQ(own(2), (Samples{{1}, {1}}));
}

// A tool that reads a sample of a participant that is gone lists its nodes for good.
class EndOfAProcess : public GraphChanges {
 protected:
  Samples of_others() {
    return theirs_.of([&](const auto& gid) { return !is_own(gid); });
  }
  void expect_no_sample_of_the_end(const std::string& mode, std::size_t nodes,
                                   const std::function<void(ChildProcess&)>& end) {
    ChildProcess peer{"peer", {mode}};
    const auto has_started = [&] {
      const auto samples = of_others();
      return !samples.empty() && samples.back().size() == nodes;
    };
    ASSERT_TRUE(spin_until(has_started, kTimeout, node_));
    end(peer);
    const auto is_gone = [&] { return theirs_.writers() == 1; };  // of this process
    ASSERT_TRUE(spin_until(is_gone, kTimeout, node_));
    const auto samples = of_others();
    EXPECT_TRUE(std::is_sorted(samples.begin(), samples.end(), is_smaller))
        << testing::PrintToString(samples);
  }

 private:
  // Also the newest sample of a process that is discovered after it has made its nodes.
  EverySample theirs_{*participant_, rt::Durability::kTransientLocal};

  static bool is_smaller(const EverySample::Sizes& one, const EverySample::Sizes& other) {
    return std::reduce(one.begin(), one.end(), one.size()) <
           std::reduce(other.begin(), other.end(), other.size());
  }
};

TEST_F(EndOfAProcess, BySignalIsNotPublished) {
  expect_no_sample_of_the_end("pair", 2, [](ChildProcess& peer) {
    peer.send(SIGTERM);
    EXPECT_EQ(peer.wait(kTimeout), 0);
  });
}

TEST_F(EndOfAProcess, WithoutASignalIsNotPublished) {
  std::optional<rt::Service> service;
  expect_no_sample_of_the_end("ask", 2, [&](ChildProcess& peer) {
    service.emplace(node_.create_service(rt::ServiceName<std_srvs::srv::Trigger>{"trigger"},
                                         [](const auto&, auto&) {}));
    std::optional<int> status;
    EXPECT_TRUE(spin_until([&] { return (status = peer.wait(0.0)).has_value(); }, kTimeout, node_));
    EXPECT_EQ(status, 0);
  });
}

}  // namespace
}  // namespace tandem
