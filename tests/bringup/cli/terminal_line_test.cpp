// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/terminal_line.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tandem {
namespace {

constexpr std::size_t kWidth = 80;

TEST(TerminalLine, ShowsTheClearanceOrADashIfItIsUnknown) {
  EXPECT_EQ(one_line(clearance_text(0.124), kWidth), "clearance 0.12 m");
  EXPECT_EQ(one_line(clearance_text(std::numeric_limits<double>::quiet_NaN()), kWidth),
            "clearance -");
}

TEST(TerminalLine, KeepsPrintableAsciiAndFitsTheTerminal) {
  EXPECT_EQ(one_line("a\nb\x1b[2J\x7f", kWidth), "a?b?[2J?");
  EXPECT_EQ(one_line("\xe2\x80\x93", kWidth), "???");
  EXPECT_EQ(one_line(std::string(100, 'a'), kWidth), std::string(kWidth - 1, 'a'));
}

}  // namespace
}  // namespace tandem
