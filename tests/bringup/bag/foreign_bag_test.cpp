// SPDX-License-Identifier: Apache-2.0
// Tests recordings from other tools: compressed, from older releases, or with clock jumps.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "bringup/bag/bag.hpp"
#include "bringup/bag/bag_qos.hpp"
#include "bringup/scenario/replay.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kToday = 1'700'000'000 * kSecond;  // [ns since 1970]
const BagTopic kJoy{"/joy", "sensor_msgs/msg/Joy", rt::kDefault};

Bytes message(int i) { return {0, 1, 0, 0, static_cast<std::uint8_t>(i)}; }

Bytes compressed(const Bytes& plain) {
  Bytes packed(ZSTD_compressBound(plain.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 1));
  return packed;
}

Bytes bytes_of(const fs::path& file) {
  std::ifstream stream{file, std::ios::binary};
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_file(const fs::path& file, const Bytes& bytes) {
  std::ofstream{file, std::ios::binary}.write(reinterpret_cast<const char*>(bytes.data()),
                                              static_cast<std::streamsize>(bytes.size()));
}

class ForeignBag : public testing::TestWithParam<BagStorage> {
 protected:
  ForeignBag() {
    char name[] = "/tmp/tandem_foreign_bag_XXXXXX";
    root_ = mkdtemp(name);
    folder_ = root_ / "drive";
    file_ = folder_ / name_;
  }
  ~ForeignBag() override { fs::remove_all(root_); }

  void write(const std::vector<std::pair<std::int64_t, Bytes>>& messages) const {
    BagWriter writer{folder_, GetParam()};
    const int topic = writer.add_topic(kJoy);
    for (const auto& [time, bytes] : messages) writer.write(topic, time, bytes);
  }
  void write_some() const { write({{1, message(1)}, {2, message(2)}}); }

  void execute(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  void compress_file() const {
    write_file(file_.string() + ".zstd", compressed(bytes_of(file_)));
    fs::remove(file_);
  }

  void describe(const std::string& fields) const {
    std::ofstream{folder_ / "metadata.yaml"} << "rosbag2_bagfile_information: {" << fields << "}\n";
  }

  static std::vector<Bytes> read(const std::string& path) {
    BagReader reader{path};
    std::vector<Bytes> all;
    for (BagMessage message; reader.next(message);) all.push_back(message.bytes);
    return all;
  }

  // The reader's message about the recording; empty if it reads all of it.
  static std::string complaint(const std::string& path) {
    try {
      (void)read(path);
      return "";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string{error.what()}.find('\n'), std::string::npos) << error.what();
      return error.what();
    }
  }

  const bool is_mcap_ = GetParam() == BagStorage::kMcap;
  const std::string name_ = is_mcap_ ? "drive_0.mcap" : "drive_0.db3";
  fs::path root_, folder_, file_;
};

INSTANTIATE_TEST_SUITE_P(Storages, ForeignBag,
                         testing::Values(BagStorage::kMcap, BagStorage::kSqlite),
                         [](const auto& storage) { return name(storage.param); });

const std::vector<Bytes> kSome{message(1), message(2)};

TEST_P(ForeignBag, CompressedByMessageGivesPlainCdr) {
  write({{1, compressed(message(1))}, {2, compressed(message(2))}});
  EXPECT_EQ(read(folder_), kSome);
  EXPECT_EQ(read(file_), kSome);
}

TEST_P(ForeignBag, CompressedByFileIsReadAndLeavesNothingBehind) {
  write_some();
  compress_file();
  setenv("TMPDIR", root_.c_str(), 1);
  EXPECT_EQ(read(folder_), kSome);
  EXPECT_EQ(read(file_.string() + ".zstd"), kSome);
  unsetenv("TMPDIR");
  EXPECT_EQ(std::distance(fs::directory_iterator{root_}, {}), 1);
}

TEST_P(ForeignBag, ThatRosbag2DecompressedBesideTheCompressedFileIsReadOnce) {
  write_some();
  write_file(file_.string() + ".zstd", compressed(bytes_of(file_)));
  EXPECT_EQ(read(folder_), kSome);
}

TEST_P(ForeignBag, OfTornCompressedBytesIsRefusedByName) {
  Bytes packed = compressed(Bytes(5000, 7));
  packed.resize(packed.size() - 3);
  write({{1, packed}});
  EXPECT_NE(complaint(folder_).find(name_ + ": a message is damaged"), std::string::npos)
      << complaint(folder_);
  compress_file();
  const fs::path file = file_.string() + ".zstd";
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_NE(complaint(folder_).find(name_ + ".zstd: zstd: truncated"), std::string::npos)
      << complaint(folder_);
}

TEST_P(ForeignBag, OfAnotherFormatIsRefusedByTheFieldAndTheCommandThatHelps) {
  write_some();
  const auto expect = [&](const std::string& field) {
    const std::string text = complaint(folder_);
    EXPECT_NE(text.find(field), std::string::npos) << text;
    EXPECT_NE(text.find("ros2 bag convert -i " + folder_.string()), std::string::npos) << text;
  };
  describe("storage_identifier: rosbag_v2");
  expect("storage_identifier is 'rosbag_v2'");
  describe("storage_identifier: sqlite3, compression_format: lz4, compression_mode: MESSAGE");
  expect("compression_format is 'lz4'");
  describe("storage_identifier: sqlite3, compression_format: '', compression_mode: ''");
  EXPECT_EQ(complaint(folder_), "");
  if (is_mcap_) return;  // its channels of another encoding: mcap_reader_test.cpp
  execute("UPDATE topics SET serialization_format = 'protobuf'");
  expect("serialization_format of /joy is 'protobuf'");
}

TEST_P(ForeignBag, OfEloquentIsOfferedSoThatAnySubscriptionMatches) {
  if (is_mcap_) return;  // Eloquent has no MCAP
  write_some();
  execute("ALTER TABLE topics DROP COLUMN offered_qos_profiles");
  EXPECT_EQ(read(folder_), kSome);
  const rt::QoS qos = BagReader{folder_}.topics().front().qos;
  EXPECT_EQ(qos.reliability, rt::Reliability::kReliable);
  EXPECT_EQ(qos.durability, rt::Durability::kTransientLocal);
}

TEST_P(ForeignBag, ThatBeganBeforeTheClockWasSetGoesOnWithoutTheGap) {
  const std::int64_t boot = 3 * kSecond;  // 1970
  write({{boot, message(0)},
         {boot + kSecond, message(1)},
         {kToday, message(2)},
         {kToday + kSecond, message(3)}});
  BagReader reader{folder_};
  std::vector<std::int64_t> times;
  for (BagMessage message; reader.next(message);) times.push_back(message.time);
  EXPECT_EQ(times, (std::vector{boot, boot + kSecond, boot + kSecond, boot + 2 * kSecond}));
  EXPECT_EQ(reader.skipped(), kToday - boot - kSecond);
}

TEST_P(ForeignBag, WithALongPauseKeepsIt) {
  write({{kToday, message(0)}, {kToday + 7200 * kSecond, message(1)}});
  BagReader reader{folder_};
  BagMessage last;
  while (reader.next(last)) {
  }
  EXPECT_EQ(last.time, kToday + 7200 * kSecond);
  EXPECT_EQ(reader.skipped(), 0);
}

TEST(RecordedQos, KeepsTheMessagesOfEveryLatchedPublisher) {
  const std::string one = "- {history: 1, depth: 1, reliability: 1, durability: 1}\n";
  EXPECT_EQ(recorded_qos("/map", one), rt::kLatched);
  EXPECT_EQ(recorded_qos("/map", one + one + one).depth, 3);
  EXPECT_GE(recorded_qos("/robot/tf_static", one).depth, 100);
}

TEST(RecordedQos, PromisesTheMostOfSeveralPublishers) {
  const std::string weak = "- {history: keep_last, depth: 3, reliability: best_effort}\n";
  const rt::QoS alone = recorded_qos("/scan", weak);
  EXPECT_EQ(alone.reliability, rt::Reliability::kBestEffort);
  EXPECT_EQ(alone.depth, 3);
  const rt::QoS both =
      recorded_qos("/scan", weak + "- {reliability: reliable, durability: volatile}\n");
  EXPECT_EQ(both.reliability, rt::Reliability::kReliable);
  EXPECT_EQ(both.durability, rt::Durability::kVolatile);
}

TEST(RecordedQos, TakesADepthOfZeroForUnknown) {
  EXPECT_EQ(recorded_qos("/joy", "- {history: 3, depth: 0, reliability: 1, durability: 2}"),
            rt::kDefault);
}

TEST(ForeignBags, OfUsersHoldTheStick) {
  if (!fs::exists(test::shared_path("cases"))) GTEST_SKIP() << "the recordings are not here";
  for (const char* name : {"zstd_message", "zstd_file", "eloquent"}) {
    const auto stick = recorded_stick(test::shared_path("cases/") + name, {});
    EXPECT_EQ(stick.t.size(), 40U) << name;
    EXPECT_NEAR(stick.t.back(), 1.95, 1e-9) << name;
    EXPECT_GT(stick.linear.back(), 0.0) << name;
  }
  const BagReader three{test::shared_path("cases/tf_static_three/a_0.db3")};
  EXPECT_GE(three.topics().front().qos.depth, 3);
}

}  // namespace
}  // namespace tandem
