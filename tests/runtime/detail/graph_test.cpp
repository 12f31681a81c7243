// SPDX-License-Identifier: Apache-2.0
// Checks byte by byte what ROS 2 tools read about Tandem's nodes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/node.hpp"
#if !TANDEM_FASTDDS_3
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#endif

namespace tandem {
namespace {

using rmw_dds_common::msg::ParticipantEntitiesInfo;
using test::kTimeout;
using test::spin_until;

class GraphTest : public testing::Test {
 protected:
  // Drains the reader; true once the last sample satisfies `predicate`.
  template <class Predicate>
  bool see(Predicate predicate) {
    return spin_until(
        [&] {
          reader_.drain();
          EXPECT_FALSE(malformed_);
          return info_ && predicate(*info_);
        },
        kTimeout, node_);
  }

  rt::Node node_{rt::NodeOptions{.name = "seen", .ns = "/robot", .serves_tools = false}};
  std::shared_ptr<rt::Participant> participant_ = rt::Participant::shared();
  rt::Codec codec_{rt::type_ref<ParticipantEntitiesInfo>()};
  std::optional<ParticipantEntitiesInfo> info_;
  rt::Bytes bytes_;
  bool malformed_ = false;
  rt::Reader reader_{*participant_,
                     {"ros_discovery_info", codec_.dds_name(), rt::kLatched},
                     [this](const rt::Bytes& bytes, const auto&) {
                       bytes_ = bytes;
                       info_.emplace();
                       return codec_.decode(bytes, &*info_);
                     },
                     {[this](std::size_t) { malformed_ = true; }, [] {}}};
};

TEST_F(GraphTest, UsesRos2sTypeName) {
  EXPECT_EQ(codec_.dds_name(), "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
}

// The process has one reader of /clock, which `ros2 node info` shows at each node that follows it.
TEST_F(GraphTest, ListsTheReaderOfTheClockAtEachNodeThatFollowsIt) {
  const auto readers = [&](std::size_t node) {
    return info_->node_entities_info_seq()[node].reader_gid_seq();
  };
  const auto follower = [](const char* name) {
    return rt::NodeOptions{.name = name, .use_sim_time = true, .serves_tools = false};
  };
  rt::Node first{follower("a_follower")};
  std::optional<rt::Node> second{std::in_place, follower("b_follower")};
  ASSERT_TRUE(see([&](const auto& info) {
    return info.node_entities_info_seq().size() == 3 && readers(1).size() == 1;
  }));
  ASSERT_EQ(readers(0).size(), 1U);
  EXPECT_EQ(readers(0)[0].data(), readers(1)[0].data());
  EXPECT_EQ(readers(2).size(), 0U) << "has no simulated time";
  second.reset();
  ASSERT_TRUE(see([](const auto& info) { return info.node_entities_info_seq().size() == 2; }));
  EXPECT_EQ(readers(0).size(), 1U);
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

// Set before the first node of the process makes the participant.
struct SpeakingHumble {
  SpeakingHumble() { setenv("ROS_DISTRO", "humble", 1); }
  ~SpeakingHumble() { unsetenv("ROS_DISTRO"); }
};
class HumbleGraphTest : private SpeakingHumble, public GraphTest {};

TEST_F(HumbleGraphTest, EncodesGidsOfTwentyFourBytes) {
  ASSERT_TRUE(spin_until([&] { return reader_.drain() > 0 || !bytes_.empty(); }, kTimeout, node_));
  EXPECT_TRUE(malformed_);        // to one who expects the other form
  EXPECT_EQ(bytes_.size(), 64U);  // eight more than from Iron on, and zero
  EXPECT_EQ(bytes_[4 + 24], 1);
  EXPECT_TRUE(std::all_of(bytes_.begin() + 4 + 16, bytes_.begin() + 4 + 24,
                          [](auto byte) { return byte == 0; }));
}

TEST_F(GraphTest, ForgetsRemovedEndpoints) {
  const rt::Topic<std_msgs::msg::Bool> topic{"e_stop"};
  {
    rt::Node other{rt::NodeOptions{.name = "brief", .serves_tools = false}};
    const auto publisher = node_.create_publisher(topic);
    ASSERT_TRUE(see([](const auto& info) { return info.node_entities_info_seq().size() == 2; }));
  }
  EXPECT_TRUE(see([](const auto& info) {
    const auto& nodes = info.node_entities_info_seq();
    return nodes.size() == 1 && nodes[0].writer_gid_seq().empty();
  }));
}

// Another participant, which notes what every writer says of its type.
class HashListener final : public rt::fdds::DomainParticipantListener {
 public:
  // By DDS topic; empty text: a writer without USER_DATA.
  [[nodiscard]] std::map<std::string, std::string> seen() const {
    const std::lock_guard lock{mutex_};
    return seen_;
  }

#if TANDEM_FASTDDS_3
  void on_data_writer_discovery(rt::fdds::DomainParticipant*, rt::rtps::WriterDiscoveryStatus,
                                const rt::rtps::PublicationBuiltinTopicData& info, bool&) override {
    note(info.topic_name.to_string(), info.user_data);
  }
#else
  void on_publisher_discovery(rt::fdds::DomainParticipant*,
                              rt::rtps::WriterDiscoveryInfo&& info) override {
    note(info.info.topicName().to_string(), info.info.m_qos.m_userData);
  }
#endif

 private:
  template <class UserData>
  void note(const std::string& topic, const UserData& data) {
    const std::lock_guard lock{mutex_};
    seen_[topic] = std::string{data.begin(), data.end()};
  }

  mutable std::mutex mutex_;
  std::map<std::string, std::string> seen_;
};

TEST(EnclaveOnTheWire, IsWhereRos2LooksForIt) {
  rt::set_enclave("/a/b");
  const auto qos = rt::Participant::shared()->dds().get_qos();
  rt::set_enclave("/");
  const auto& data = qos.user_data();
  EXPECT_EQ((std::string{data.begin(), data.end()}), "enclave=/a/b;");
  EXPECT_EQ(qos.name().to_string(), "/a/b");
}

class TypeHashOnTheWire : public GraphTest {
 protected:
  // What is said of the topic's type; waits for its discovery.
  std::string said_of(const std::string& topic) {
    auto* factory = rt::fdds::DomainParticipantFactory::get_instance();
    auto qos = participant_->dds().get_qos();  // UDP on loopback, as ours
    qos.wire_protocol().prefix = {};
    auto* other = factory->create_participant(participant_->dds().get_domain_id(), qos, &listener_,
                                              rt::fdds::StatusMask::none());
    EXPECT_TRUE(spin_until([&] { return listener_.seen().contains(topic); }, kTimeout, node_));
    other->set_listener(nullptr);
    factory->delete_participant(other);
    return listener_.seen()[topic];
  }

  HashListener listener_;
};

TEST_F(TypeHashOnTheWire, IsWhereRos2LooksForIt) {
  const auto publisher = node_.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{"/cmd_vel"});
  EXPECT_EQ(said_of("rt/cmd_vel"),
            "typehash=RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a;");
}

class HumbleTypeHashOnTheWire : private SpeakingHumble, public TypeHashOnTheWire {};

TEST_F(HumbleTypeHashOnTheWire, IsNotThere) {
  const auto publisher = node_.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{"/cmd_vel"});
  EXPECT_EQ(said_of("rt/cmd_vel"), "");
}

}  // namespace
}  // namespace tandem
