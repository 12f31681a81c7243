// SPDX-License-Identifier: Apache-2.0
// That the numbers are the message's constants is asserted where they are compiled.
#include "tandem/io/reason_code.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(ReasonCode, IsTheConstantOfTheMessage) {
  using namespace tandem_msgs::msg::ReasonCode_Constants;
  EXPECT_EQ(to_msg(Reason::kNone).value(), NONE);
  EXPECT_EQ(to_msg(Reason::kStickMoved).value(), STICK_MOVED);
  EXPECT_EQ(from_msg(to_msg(Reason::kNotEnforcing)), Reason::kNotEnforcing);
}

TEST(ReasonCode, OfALaterVersionIsAnotherReason) {
  tandem_msgs::msg::ReasonCode code;
  code.value(static_cast<std::uint8_t>(Reason::kCount));
  EXPECT_EQ(from_msg(code), Reason::kOther);
  code.value(255);
  EXPECT_EQ(from_msg(code), Reason::kOther);
}

}  // namespace
}  // namespace tandem
