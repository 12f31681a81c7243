// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/mcap_writer.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "bringup/bag/bag.hpp"
#include "bringup/bag/mcap_scan.hpp"
#include "support/mcap_file.hpp"
#include "support/temporary_folder.hpp"

namespace tandem {
namespace {

using test::Bytes;
using test::Op;

const BagTopic kTwists{"/cmd_vel", "geometry_msgs/msg/Twist", rt::kDefault};
const BagTopic kMaps{"/map", "nav_msgs/msg/OccupancyGrid", rt::kLatched};
const BagTopic kForeign{"/foreign", "their_msgs/msg/Thing", rt::kDefault};

struct Record {
  Op op{};
  mcap::View content;
  std::uint64_t offset = 0;  // of its opcode in the file
};

class McapWriting : public testing::Test {
 protected:
  // The records between the two magics.
  [[nodiscard]] std::vector<Record> records() {
    file_bytes_ = test::bytes_of(file_);
    const auto magic = mcap::kMagic.size();
    EXPECT_TRUE(std::equal(mcap::kMagic.begin(), mcap::kMagic.end(), file_bytes_.begin()));
    EXPECT_TRUE(std::equal(mcap::kMagic.begin(), mcap::kMagic.end(),
                           file_bytes_.end() - static_cast<long>(magic)));
    std::vector<Record> all;
    mcap::for_each_record(mcap::View{file_bytes_}.subspan(magic, file_bytes_.size() - 2 * magic),
                          [&](Op op, mcap::View content, std::size_t at) {
                            all.push_back({op, content, magic + at - mcap::kHead});
                          });
    return all;
  }
  static std::vector<Record> of(Op op, const std::vector<Record>& records) {
    std::vector<Record> found;
    std::copy_if(records.begin(), records.end(), std::back_inserter(found),
                 [&](const Record& record) { return record.op == op; });
    return found;
  }
  static Record only(Op op, const std::vector<Record>& records) {
    const auto found = of(op, records);
    EXPECT_EQ(found.size(), 1U);
    return found.at(0);
  }

  void write_two_chunks() const {
    BagWriter writer{bag_};
    const int command = writer.add_topic(kTwists), map = writer.add_topic(kMaps);
    writer.write(command, 10, {1});
    writer.write(map, 20, {2, 2});
    writer.commit();
    writer.write(command, 30, {3});
    writer.write(command, 25, {4});
  }

  test::TemporaryFolder folder_;
  const std::string bag_ = folder_.path() / "drive", file_ = bag_ + "/drive_0.mcap";
  Bytes file_bytes_;
};

TEST(McapFormat, RecordsAreReadAsTheyWereWritten) {
  const mcap::Schema schema{7, "a/msg/B", "ros2msg", "bool data\n"};
  const mcap::Channel channel{3, 7, "/b", "cdr", {{"key", "value"}, {"other", ""}}};
  Bytes bytes;
  mcap::Output{bytes}.record(schema);
  const mcap::View first = mcap::View{bytes}.subspan(mcap::kHead);
  EXPECT_EQ(mcap::Input{first}.schema(), schema);
  for (std::size_t size = 0; size < first.size(); ++size)
    EXPECT_THROW((void)mcap::Input{first.first(size)}.schema(), mcap::ShortRecord);

  Bytes more;
  mcap::Output{more}.record(channel);
  const mcap::View second = mcap::View{more}.subspan(mcap::kHead);
  for (std::size_t size = 0; size < second.size(); ++size)
    EXPECT_THROW((void)mcap::Input{second.first(size)}.channel(), mcap::ShortRecord);
  more.push_back(1);  // fields of later versions come behind
  EXPECT_EQ(mcap::Input{mcap::View{more}.subspan(mcap::kHead)}.channel(), channel);

  bytes.insert(bytes.end(), more.begin(), more.end() - 1);
  std::vector<Op> ops;
  mcap::for_each_record(bytes, [&](Op op, mcap::View, std::size_t) { ops.push_back(op); });
  EXPECT_EQ(ops, (std::vector{Op::kSchema, Op::kChannel}));
}

TEST(McapFormat, ChecksumIsThatOfZlib) {
  const std::string text = "123456789";
  const Bytes bytes{text.begin(), text.end()};
  EXPECT_EQ(mcap::crc32(bytes), 0xcbf43926U);
  EXPECT_EQ(mcap::crc32(mcap::View{bytes}.subspan(4), mcap::crc32(mcap::View{bytes}.first(4))),
            0xcbf43926U);
}

TEST_F(McapWriting, IndexLeadsToEveryMessage) {
  write_two_chunks();
  const auto all = records();
  const auto chunks = of(Op::kChunk, all), indexes = of(Op::kChunkIndex, all);
  ASSERT_EQ(chunks.size(), 2U);
  ASSERT_EQ(indexes.size(), 2U);
  const mcap::File file{file_, file_};
  std::vector<std::uint64_t> times;
  for (std::size_t i = 0; i < 2; ++i) {
    mcap::Input index{indexes[i].content};
    EXPECT_EQ(index.u64(), i == 0 ? 10U : 25U);
    EXPECT_EQ(index.u64(), i == 0 ? 20U : 30U);
    EXPECT_EQ(index.u64(), chunks[i].offset);
    EXPECT_EQ(index.u64(), chunks[i].content.size() + mcap::kHead);
    const Bytes plain =
        mcap::records_of(file, {0, chunks[i].offset + mcap::kHead, chunks[i].content.size(), true});
    for (mcap::Input offsets{index.raw(index.u32())}; !offsets.rest().empty();) {
      const std::uint16_t channel = offsets.u16();
      const Bytes head = file.read(offsets.u64(), mcap::kHead + 6);
      mcap::Input entry{head};
      EXPECT_EQ(static_cast<Op>(entry.u8()), Op::kMessageIndex);
      (void)entry.u64();
      EXPECT_EQ(entry.u16(), channel);
    }
    for (const Record& record : of(Op::kMessageIndex, all)) {
      if (record.offset < chunks[i].offset || (i == 0 && record.offset > chunks[1].offset))
        continue;
      mcap::Input in{record.content};
      const std::uint16_t channel = in.u16();
      for (mcap::Input entries{in.raw(in.u32())}; !entries.rest().empty();) {
        times.push_back(entries.u64());
        mcap::Input message{mcap::View{plain}.subspan(entries.u64())};
        EXPECT_EQ(static_cast<Op>(message.u8()), Op::kMessage);
        (void)message.u64();
        const mcap::Message fields = message.message();
        EXPECT_EQ(fields.channel, channel);
        EXPECT_EQ(fields.time, times.back());
      }
    }
  }
  EXPECT_EQ(times, (std::vector<std::uint64_t>{10, 20, 30, 25}));
}

TEST_F(McapWriting, SummaryRepeatsWhatADataSectionHas) {
  write_two_chunks();
  const auto all = records();
  mcap::Input footer{only(Op::kFooter, all).content};
  const std::uint64_t start = footer.u64(), offsets = footer.u64();
  const std::size_t crc_at = file_bytes_.size() - mcap::kMagic.size() - 4;
  EXPECT_EQ(footer.u32(), mcap::crc32(mcap::View{file_bytes_}.subspan(start, crc_at - start)));
  const Record end = only(Op::kDataEnd, all);
  EXPECT_EQ(mcap::Input{end.content}.u32(),
            mcap::crc32(mcap::View{file_bytes_}.first(static_cast<std::size_t>(end.offset))));
  EXPECT_EQ(start, end.offset + mcap::kHead + end.content.size());
  EXPECT_EQ(of(Op::kSchema, all).size(), 2U);
  EXPECT_EQ(of(Op::kChannel, all).size(), 2U);
  EXPECT_EQ(of(Op::kSummaryOffset, all).front().offset, offsets);
  for (const Record& record : of(Op::kSummaryOffset, all)) {
    mcap::Input in{record.content};
    const auto op = static_cast<Op>(in.u8());
    EXPECT_EQ(of(op, all).front().offset, in.u64());
  }
  mcap::Input statistics{only(Op::kStatistics, all).content};
  EXPECT_EQ(statistics.u64(), 4U);
  EXPECT_EQ(statistics.u16(), 2U);
  EXPECT_EQ(statistics.u32(), 2U);
  mcap::Input header{only(Op::kHeader, all).content};
  EXPECT_EQ(header.text(), "ros2");
  mcap::Input metadata{only(Op::kMetadata, all).content};
  EXPECT_EQ(metadata.text(), "rosbag2");
  EXPECT_NE(metadata.map().at("serialized_metadata").find("message_count: 4"), std::string::npos);
}

TEST_F(McapWriting, ChannelsHaveQosHashAndDefinitionWhereItIsKnown) {
  BagTopic other_twist{"/other", "geometry_msgs/msg/Twist", rt::kDefault, "RIHS01_other"};
  {
    BagWriter writer{bag_};
    for (const BagTopic& topic : {kTwists, kMaps, kForeign, other_twist}) writer.add_topic(topic);
  }
  const mcap::File file{file_, file_};
  const mcap::Contents contents = mcap::scan(file);
  const mcap::Channel map = contents.channels.at(2);
  EXPECT_NE(map.metadata.at("offered_qos_profiles").find("durability: transient_local"),
            std::string::npos);
  EXPECT_TRUE(map.metadata.at("topic_type_hash").starts_with("RIHS01_"));
  const mcap::Schema twist = contents.schemas.at(contents.channels.at(1).schema);
  EXPECT_EQ(twist.encoding, "ros2msg");
  EXPECT_NE(twist.text.find(std::string(80, '=') + "\nMSG: geometry_msgs/Vector3\nfloat64 x\n"),
            std::string::npos);
  for (const std::uint16_t unknown : {std::uint16_t{3}, std::uint16_t{4}}) {
    const mcap::Schema schema = contents.schemas.at(contents.channels.at(unknown).schema);
    EXPECT_EQ(schema.encoding + schema.text, "");
  }
  EXPECT_EQ(contents.channels.at(4).metadata.at("topic_type_hash"), "RIHS01_other");
  EXPECT_EQ(BagReader{bag_}.topics().at(3).type_hash, "RIHS01_other");
  EXPECT_EQ(BagReader{bag_}.topics().at(1).qos, rt::kLatched);
}

TEST_F(McapWriting, LosesAtMostOneMebibyteWithoutACommit) {
  constexpr int kMessages = 40;
  const pid_t child = fork();
  if (child == 0) {
    BagWriter writer{bag_};
    const int id = writer.add_topic(kMaps);
    for (int i = 1; i <= kMessages; ++i) writer.write(id, i, Bytes(100'000, 7));
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  BagReader reader{bag_};
  int messages = 0;
  for (BagMessage message; reader.next(message);) ++messages;
  EXPECT_GE(messages, kMessages - 11);
}

TEST_F(McapWriting, ReportsAFullDiskAndLeavesWholeRecords) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    BagWriter writer{bag_};
    const int id = writer.add_topic(kMaps);
    writer.write(id, 1, {1});
    writer.commit();
    const rlim_t now = test::bytes_of(file_).size();
    const rlimit limit{now + 100, now + 100};
    setrlimit(RLIMIT_FSIZE, &limit);
    Bytes noise(10'000);
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint8_t>(i * i / 7);
    writer.write(id, 2, noise);
    try {
      writer.commit();
    } catch (const std::runtime_error& error) {
      const bool is_right = std::string{error.what()}.starts_with(file_ + ": cannot be written") &&
                            test::bytes_of(file_).size() == now;
      _exit(is_right ? 0 : 1);
    }
    _exit(2);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace tandem
