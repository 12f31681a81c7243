// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/single_source.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

using enum SingleSource::Type;

constexpr double kTimeout = 0.1;  // [s]

SingleSource::Writer writer(std::uint8_t process, std::uint8_t participant, std::uint8_t entity) {
  SingleSource::Writer id{};
  id[7] = process;
  id[11] = participant;
  id[15] = entity;
  return id;
}

const auto kFilter = writer(1, 0, 1);

TEST(SingleSource, OneWriterDrives) {
  SingleSource source{kTimeout};
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(source.on_command(kFilter, kTwist, 0.02 * i));
}

TEST(SingleSource, NeitherDrivesWhileTwoWritersPublish) {
  SingleSource source{kTimeout};
  EXPECT_TRUE(source.on_command(kFilter, kTwist, 0.0));
  for (int i = 1; i < 100; ++i) {
    EXPECT_FALSE(source.on_command(writer(2, 0, 1), kTwist, 0.05 * i)) << i;
    EXPECT_FALSE(source.on_command(kFilter, kTwist, 0.05 * i + 0.02)) << i;
  }
}

TEST(SingleSource, TwoWritersOfOneTypeAreTwoSourcesInOneProcessToo) {
  SingleSource source{kTimeout};
  EXPECT_TRUE(source.on_command(kFilter, kTwist, 0.0));
  EXPECT_FALSE(source.on_command(writer(1, 0, 2), kTwist, 0.01));
}

TEST(SingleSource, TwistAndTwistStampedOfOneProcessAreOneSource) {
  SingleSource source{kTimeout};
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(source.on_command(kFilter, kTwist, 0.02 * i));
    EXPECT_TRUE(source.on_command(writer(1, 1, 3), kTwistStamped, 0.02 * i + 0.001));
  }
  EXPECT_FALSE(source.on_command(writer(2, 1, 3), kTwistStamped, 0.2));
}

// Under DDS Security the bytes that identify the process are a hash.
TEST(SingleSource, TwistAndTwistStampedOfOneEnclaveAreOneSource) {
  const auto secured = [](std::uint8_t enclave, std::uint8_t participant) {
    SingleSource::Writer id = writer(participant, participant, 3);
    id[0] = 0x80;
    id[5] = enclave;
    return id;
  };
  SingleSource source{kTimeout};
  EXPECT_TRUE(source.on_command(secured(1, 1), kTwist, 0.0));
  EXPECT_TRUE(source.on_command(secured(1, 2), kTwistStamped, 0.01));
  EXPECT_FALSE(source.on_command(secured(1, 3), kTwist, 0.02));
  EXPECT_FALSE(source.on_command(secured(2, 4), kTwistStamped, 0.03));
}

TEST(SingleSource, AWriterThatIsSilentForTheTimeoutDoesNotCount) {
  SingleSource source{kTimeout};
  EXPECT_TRUE(source.on_command(kFilter, kTwist, 0.0));
  EXPECT_FALSE(source.on_command(writer(2, 0, 1), kTwist, 0.1));
  EXPECT_TRUE(source.on_command(writer(2, 0, 1), kTwist, 0.11));
}

TEST(SingleSource, AClockResetLocksNoWriterOut) {
  SingleSource source{kTimeout};
  EXPECT_TRUE(source.on_command(kFilter, kTwist, 100.0));
  EXPECT_TRUE(source.on_command(writer(2, 0, 1), kTwist, 1.0));
}

}  // namespace
}  // namespace tandem
