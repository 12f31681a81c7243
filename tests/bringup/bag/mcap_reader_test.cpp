// SPDX-License-Identifier: Apache-2.0
// Reads MCAP files of other writers, and such as are cut off, damaged or hostile.
#include "bringup/bag/mcap_reader.hpp"

#include <gtest/gtest.h>

#include "bringup/bag/bag.hpp"
#include "bringup/bag/lz4.hpp"
#include "bringup/bag/zstd.hpp"
#include "support/captured_log.hpp"
#include "support/mcap_file.hpp"
#include "support/temporary_folder.hpp"

namespace tandem {
namespace {

using test::Bytes;
using test::McapRecords;
using test::Op;

using Values = std::vector<int>;

class McapReading : public testing::Test {
 protected:
  // The last byte of each message, in order.
  [[nodiscard]] Values read(const Bytes& bytes) const {
    test::write_file(file_, bytes);
    McapReader reader{file_, file_};
    Values values;
    for (BagMessage message; reader.next(message);) values.push_back(message.bytes.back());
    return values;
  }
  [[nodiscard]] Values read(const McapRecords& records) const {
    return read(test::mcap_file(records));
  }
  // The reader's message about the file; empty if it reads all of it.
  [[nodiscard]] std::string complaint(const Bytes& bytes) const {
    try {
      (void)read(bytes);
      return "";
    } catch (const std::runtime_error& error) {
      EXPECT_TRUE(std::string{error.what()}.starts_with(file_ + ": ")) << error.what();
      EXPECT_EQ(std::string{error.what()}.find('\n'), std::string::npos) << error.what();
      return error.what();
    }
  }
  [[nodiscard]] std::string complaint(const McapRecords& records) const {
    return complaint(test::mcap_file(records));
  }

  static McapRecords described() { return McapRecords{}.schema().channel(); }
  static McapRecords some() { return described().message(1, 1).message(2, 2); }

  test::TemporaryFolder folder_;
  const std::string file_ = folder_.path() / "drive_0.mcap";
};

TEST_F(McapReading, TakesMessagesInsideAndOutsideOfChunksInOrderOfTime) {
  EXPECT_EQ(read(some()), (Values{1, 2}));
  EXPECT_EQ(read(McapRecords{}.chunk(some())), (Values{1, 2}));
  // Chunks that overlap, and a message between them.
  const McapRecords first = described().message(30, 3).message(10, 1),
                    second = McapRecords{}.message(20, 2).message(50, 5);
  EXPECT_EQ(read(McapRecords{}.chunk(first, 10).chunk(second, 20).message(40, 4)),
            (Values{1, 2, 3, 4, 5}));
}

TEST_F(McapReading, IgnoresRecordsThatItDoesNotNeed) {
  const auto anything = [](mcap::Output& out) { out.text("anything"); };
  McapRecords records = described();
  for (const int op : {7, 9, 12, 0x42, 0x80, 0xff}) records.record(static_cast<Op>(op), anything);
  records.message(1, 1);
  EXPECT_EQ(read(records), Values{1});
  EXPECT_EQ(read(McapRecords{}.chunk(records)), Values{1});
}

TEST_F(McapReading, DecompressesZstd) {
  const Bytes plain = some().bytes();
  EXPECT_EQ(read(McapRecords{}.chunk(compress(plain), plain.size(), mcap::crc32(plain), "zstd")),
            (Values{1, 2}));
  test::write_file(file_ + ".zstd", compress(test::mcap_file(some())));
  BagReader reader{file_ + ".zstd"};
  BagMessage message;
  ASSERT_TRUE(reader.next(message));
  EXPECT_EQ(message.bytes.back(), 1);
}

// A frame of one block that is stored as it is.
Bytes lz4_frame(const Bytes& plain) {
  Bytes frame{0x04, 0x22, 0x4d, 0x18, 0x60, 0x40, 0x82};
  mcap::Output out{frame};
  out.u32(static_cast<std::uint32_t>(plain.size()) | 0x8000'0000U);
  out.raw(plain);
  out.u32(0);
  return frame;
}

TEST_F(McapReading, DecompressesLz4OrNamesIt) {
  const Bytes plain = some().bytes();
  const McapRecords packed = McapRecords{}.chunk(lz4_frame(plain), plain.size(), 0, "lz4");
  if (kHasLz4) {
    EXPECT_EQ(read(packed), (Values{1, 2}));
    Bytes torn = lz4_frame(plain);
    torn.resize(torn.size() - 8);
    EXPECT_NE(complaint(McapRecords{}.chunk(torn, plain.size(), 0, "lz4")).find("lz4: truncated"),
              std::string::npos);
  } else {
    const std::string text = complaint(packed);
    EXPECT_NE(text.find("compressed with 'lz4'"), std::string::npos) << text;
    EXPECT_NE(text.find("mcap compress --compression zstd " + file_), std::string::npos) << text;
  }
  const std::string text = complaint(McapRecords{}.chunk(plain, plain.size(), 0, "snappy"));
  EXPECT_NE(text.find("compressed with 'snappy'"), std::string::npos) << text;
}

TEST_F(McapReading, GivesTypesTheirFullNames) {
  test::write_file(file_, test::mcap_file(McapRecords{}
                                              .schema(1, "std_msgs/Bool")
                                              .channel(1, "/short")
                                              .schema(2, "std_msgs/msg/Bool")
                                              .channel(2, "/full", "cdr", 2)
                                              .channel(3, "/none", "cdr", 0)));
  const McapReader reader{file_, file_};
  std::vector<std::string> types;
  for (const BagTopic& topic : reader.topics()) types.push_back(topic.type);
  EXPECT_EQ(types, (std::vector<std::string>{"std_msgs/msg/Bool", "std_msgs/msg/Bool", ""}));
}

TEST_F(McapReading, OfAFileThatWasCutOffGivesEverythingBeforeAndOneWarning) {
  const McapRecords more = McapRecords{}.message(3, 3);
  const Bytes whole = test::mcap_file(McapRecords{}.chunk(some()).chunk(more, 3).message(4, 4));
  const Values all{1, 2, 3, 4};
  const test::CapturedLog log;
  std::size_t before = 0;
  for (std::size_t size = 8; size < whole.size(); ++size) {
    const Values values = read(Bytes{whole.begin(), whole.begin() + static_cast<long>(size)});
    EXPECT_TRUE(values.size() <= all.size() &&
                std::equal(values.begin(), values.end(), all.begin()))
        << size;
    EXPECT_GE(values.size(), before) << size;
    before = values.size();
  }
  EXPECT_EQ(before, all.size());
  Bytes zeros = whole;  // a file system's, after the power was lost
  std::fill(zeros.end() - 86, zeros.end(), 0);
  EXPECT_EQ(read(zeros), (Values{1, 2, 3}));
  EXPECT_EQ(log.lines("drive_0.mcap: has no end"), 1) << log.text();
  EXPECT_NE(complaint(Bytes{whole.begin(), whole.begin() + 7}), "");
}

TEST_F(McapReading, ReportsDamageByFileAndByteAndWhatMendsIt) {
  const auto expect = [&](const std::string& text, const std::string& what) {
    EXPECT_NE(text.find(what), std::string::npos) << text;
    EXPECT_NE(text.find(": byte "), std::string::npos) << text;
    EXPECT_NE(text.find("mcap recover " + file_ + " -o saved.mcap"), std::string::npos) << text;
  };
  expect(complaint(Bytes(100, 'x')), "byte 0: this is no MCAP file");
  expect(complaint(McapRecords{}.record(Op{0}, [](mcap::Output&) {})), "invalid opcode 0");
  expect(complaint(McapRecords{}.chunk(some().bytes(), some().bytes().size(), 1)), "checksum");
  expect(complaint(McapRecords{}.chunk(some().bytes(), 3)), "it has not the size");
  expect(complaint(described().schema(1, "std_msgs/msg/Int8")), "two different schemas");
  expect(complaint(described().channel(1, "/b")), "two different channels");
  Bytes torn = some().bytes();
  torn.pop_back();
  expect(complaint(McapRecords{}.chunk(torn, torn.size())), "longer than its record");
  expect(complaint(some().message(3, 3, 9)), "channel 9");
  EXPECT_NE(complaint(McapRecords{}.schema().channel(1, "/a", "json")).find("is 'json', not cdr"),
            std::string::npos);
}

TEST_F(McapReading, DoesNotBelieveALengthThatTheFileCannotHold) {
  const std::uint64_t huge = std::uint64_t{1} << 62U;
  EXPECT_NE(complaint(McapRecords{}.chunk(some().bytes(), huge)).find("1 GiB"), std::string::npos);
  Bytes file = test::mcap_file(some());
  mcap::Bytes head;
  mcap::Output{head}.u64(huge);
  std::copy(head.begin(), head.end(), file.begin() + 9);  // of the header
  EXPECT_NE(complaint(file).find("byte 8: a record claims to be longer than the file"),
            std::string::npos);
  // 100 MB of zeros where a few bytes are claimed
  const Bytes bomb = compress(Bytes(100'000'000));
  EXPECT_NE(complaint(McapRecords{}.chunk(bomb, 10, 0, "zstd")).find("more than 10 bytes"),
            std::string::npos);
}

TEST_F(McapReading, SurvivesEveryByteBeingWrong) {
  BagTopic topic{"/a", "std_msgs/msg/Bool"};
  {
    BagWriter writer{folder_.path() / "own"};
    const int id = writer.add_topic(topic);
    for (std::uint8_t i = 1; i < 4; ++i) writer.write(id, i, {0, 1, 0, 0, i});
  }
  const test::CapturedLog log;
  for (const Bytes& good : {test::mcap_file(McapRecords{}.chunk(some()).message(3, 3)),
                            test::bytes_of(folder_.path() / "own/own_0.mcap")})
    for (std::size_t at = 0; at < good.size(); ++at)
      for (const int bits : {0x01, 0x80, 0xff}) {
        Bytes bad = good;
        bad[at] = static_cast<std::uint8_t>(bad[at] ^ bits);
        try {
          EXPECT_LE(read(bad).size(), 3U);
        } catch (const std::runtime_error&) {  // one clear error is right, too
        }
      }
}

}  // namespace
}  // namespace tandem
