// SPDX-License-Identifier: Apache-2.0
// Checks that dropped datagrams are reported on /diagnostics, by kind and source.
#include <gtest/gtest.h>

#include <map>

#include "bringup/system/diagnoses.hpp"
#include "runtime/datagram.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "support/udp_sender.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

constexpr double kTimeout = 10.0;  // [s]

TEST(GuardReport, ReportsDropsAndTheirSourceAtMostOnceAMinute) {
  rt::Node node{"listener"};
  std::map<std::string, int> messages;  // of the guard, and how often each was said
  Diagnoses diagnoses;
  const auto subscription = node.create_subscription(
      rt::Topic<diagnostic_msgs::msg::DiagnosticArray>{"/diagnostics"}, [&](const auto& msg) {
        add(diagnoses, msg);
        for (const auto& status : msg.status()) ++messages[status.message()];
      });
  const test::UdpSender stranger;
  const auto hostile = test::datagram_files("hostile");
  stranger.send_to_all(test::read(hostile.front()), 8);
  ASSERT_TRUE(test::spin_until([&] { return !messages.empty(); }, kTimeout, node));
  EXPECT_NE(messages.begin()->first.find("inline QoS from 127.0.0.1"), std::string::npos)
      << messages.begin()->first;
  stranger.send_to_all({'n', 'o'}, 8);  // more, soon after
  ASSERT_TRUE(test::spin_until([&] { return messages.begin()->second >= 3; }, kTimeout, node));
  EXPECT_EQ(messages.size(), 1u);

  const auto found = examine(diagnoses);  // as `tandem doctor` does
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].what.find("listener: network (warning): dropped"), std::string::npos);
  EXPECT_NE(found[0].remedy.find("stop it"), std::string::npos);
}

}  // namespace
}  // namespace tandem
