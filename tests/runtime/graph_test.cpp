// SPDX-License-Identifier: Apache-2.0
// What ROS 2 tools read about our nodes, seen by a reader of bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "runtime/codec.hpp"
#include "runtime/endpoint.hpp"
#include "runtime/node.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using rmw_dds_common::msg::ParticipantEntitiesInfo;
using test::spin_until;

constexpr double kTimeout = 10.0;  // [s]

class GraphTest : public testing::Test {
 protected:
  // Drains the reader; true once the last sample satisfies `predicate`.
  template <class Predicate>
  bool see(Predicate predicate) {
    return spin_until(
        [&] {
          reader_.drain();
          return info_ && predicate(*info_);
        },
        kTimeout, node_);
  }

  rt::Node node_{rt::NodeOptions{.name = "seen", .ns = "/robot"}};
  std::shared_ptr<rt::Participant> participant_ = rt::Participant::shared();
  rt::Codec codec_{rt::type_ref<ParticipantEntitiesInfo>()};
  std::optional<ParticipantEntitiesInfo> info_;
  rt::Bytes bytes_;
  rt::Reader reader_{*participant_,
                     {"ros_discovery_info", codec_.dds_name(), rt::kLatched},
                     [this](const rt::Bytes& bytes, const auto&) {
                       bytes_ = bytes;
                       info_.emplace();
                       return codec_.decode(bytes, &*info_);
                     },
                     [](std::size_t) { ADD_FAILURE() << "malformed"; }};
};

TEST_F(GraphTest, UsesRos2sTypeName) {
  EXPECT_EQ(codec_.dds_name(), "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
}

TEST_F(GraphTest, ListsANodeWithTheGidsOfItsEndpoints) {
  const rt::Topic<std_msgs::msg::Bool> topic{"e_stop"};
  const auto publisher = node_.create_publisher(topic);
  const auto subscription = node_.create_subscription(topic, [](const auto&) {});
  const auto service = node_.create_service(rt::ServiceName<std_srvs::srv::Trigger>{"reset"},
                                            [](const auto&, auto&) {});
  ASSERT_TRUE(see([](const auto& info) {
    const auto& nodes = info.node_entities_info_seq();
    return nodes.size() == 1 && nodes[0].writer_gid_seq().size() == 2 &&
           nodes[0].reader_gid_seq().size() == 2;
  }));
  const auto& node = info_->node_entities_info_seq()[0];
  EXPECT_STREQ(node.node_namespace().c_str(), "/robot");
  EXPECT_STREQ(node.node_name().c_str(), "seen");
  const auto& prefix = participant_->dds().guid().guidPrefix.value;
  EXPECT_TRUE(std::equal(prefix, prefix + 12, info_->gid().data().begin()));
  EXPECT_EQ(std::vector<int>(info_->gid().data().begin() + 12, info_->gid().data().end()),
            (std::vector<int>{0, 0, 1, 0xc1}));  // a participant's entity id
  for (const auto& gid : node.writer_gid_seq())
    EXPECT_TRUE(std::equal(prefix, prefix + 12, gid.data().begin()));
}

TEST_F(GraphTest, EncodesGidsOfSixteenBytes) {
  ASSERT_TRUE(see([](const auto&) { return true; }));
  // encapsulation 4, gid 16, count 4, "/robot" 4+7+1, "seen" 4+5+3, two empty sequences 8
  EXPECT_EQ(bytes_.size(), 56U);
  EXPECT_EQ(bytes_[20], 1);
}

TEST_F(GraphTest, ForgetsWhatIsGone) {
  const rt::Topic<std_msgs::msg::Bool> topic{"e_stop"};
  {
    rt::Node other{"brief"};
    const auto publisher = node_.create_publisher(topic);
    ASSERT_TRUE(see([](const auto& info) { return info.node_entities_info_seq().size() == 2; }));
  }
  EXPECT_TRUE(see([](const auto& info) {
    const auto& nodes = info.node_entities_info_seq();
    return nodes.size() == 1 && nodes[0].writer_gid_seq().empty();
  }));
}

}  // namespace
}  // namespace tandem
