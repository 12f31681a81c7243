// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <yaml-cpp/yaml.h>

namespace tandem {
namespace {

namespace fs = std::filesystem;

class Bag : public testing::TestWithParam<BagStorage> {
 protected:
  Bag() {
    char name[] = "/tmp/tandem_bag_XXXXXX";
    root_ = mkdtemp(name);
    folder_ = root_ / "drive";
  }
  ~Bag() override { fs::remove_all(root_); }

  static std::vector<std::pair<std::string, BagMessage>> read(const std::string& path) {
    BagReader reader{path};
    std::vector<std::pair<std::string, BagMessage>> all;
    for (BagMessage message; reader.next(message);)
      all.emplace_back(reader.topics().at(message.topic).name, message);
    return all;
  }

  fs::path root_, folder_;
  const bool is_mcap_ = GetParam() == BagStorage::kMcap;
  const std::string ending_ = is_mcap_ ? ".mcap" : ".db3";
};

INSTANTIATE_TEST_SUITE_P(Storages, Bag, testing::Values(BagStorage::kMcap, BagStorage::kSqlite),
                         [](const auto& storage) { return name(storage.param); });

const BagTopic kCommand{"/cmd_vel", "geometry_msgs/msg/Twist", rt::kDefault};
const BagTopic kMap{"/map", "nav_msgs/msg/OccupancyGrid", rt::kLatched};

TEST_P(Bag, GivesBackWhatWasWrittenInOrderOfTime) {
  {
    BagWriter writer{folder_, GetParam()};
    const int command = writer.add_topic(kCommand), map = writer.add_topic(kMap);
    writer.write(command, 300, {0, 1, 0, 0, 7});
    writer.write(map, 100, {0, 1, 0, 0});
    writer.write(command, 200, {});
  }
  const auto all = read(folder_);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].first, "/map");
  EXPECT_EQ(all[0].second.time, 100);
  EXPECT_EQ(all[2].first, "/cmd_vel");
  EXPECT_EQ(all[2].second.bytes, (std::vector<std::uint8_t>{0, 1, 0, 0, 7}));

  const BagReader reader{folder_};
  const auto& topics = reader.topics();
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics[0].type, "geometry_msgs/msg/Twist");
  EXPECT_EQ(topics[0].qos, rt::kDefault);
  EXPECT_EQ(topics[1].qos, rt::kLatched);
}

// As rosbag2 splits: the topics again in each file, under other ids; drive_10 sorts before drive_2.
TEST_P(Bag, OfSeveralFilesIsReadAsOneInOrderOfTime) {
  fs::create_directory(root_ / "split");
  const auto write = [&](const std::string& name, std::int64_t time, const BagTopic& first,
                         const BagTopic& second) {
    {
      BagWriter writer{root_ / name, GetParam()};
      const int one = writer.add_topic(first), two = writer.add_topic(second);
      writer.write(one, time, {1});
      writer.write(two, time + 1, {2});
    }
    fs::rename(root_ / name / (name + "_0" + ending_), root_ / "split" / (name + ending_));
  };
  write("drive_2", 200, kCommand, kMap);
  write("drive_10", 300, kMap, kCommand);
  write("drive_0", 100, kCommand, kMap);
  const auto all = read(root_ / "split");
  std::vector<std::string> names;
  std::vector<std::int64_t> times;
  for (const auto& [name, message] : all) {
    names.push_back(name);
    times.push_back(message.time);
  }
  EXPECT_EQ(times, (std::vector<std::int64_t>{100, 101, 200, 201, 300, 301}));
  EXPECT_EQ(names,
            (std::vector<std::string>{"/cmd_vel", "/map", "/cmd_vel", "/map", "/map", "/cmd_vel"}));
  EXPECT_EQ(BagReader{root_ / "split"}.topics().size(), 2U);
  EXPECT_EQ(read(root_ / "split" / ("drive_2" + ending_)).size(), 2U);
}

TEST_P(Bag, DescribesItselfAsRosbag2Does) {
  {
    BagWriter writer{folder_, GetParam()};
    writer.write(writer.add_topic(kCommand), 1'000, {1});
    writer.write(writer.add_topic(kMap), 4'000, {2});
  }
  const auto info = YAML::LoadFile(folder_ / "metadata.yaml")["rosbag2_bagfile_information"];
  EXPECT_EQ(info["version"].as<int>(), is_mcap_ ? 9 : 5);
  EXPECT_EQ(info["storage_identifier"].as<std::string>(), name(GetParam()));
  EXPECT_EQ(info["duration"]["nanoseconds"].as<int>(), 3'000);
  EXPECT_EQ(info["starting_time"]["nanoseconds_since_epoch"].as<int>(), 1'000);
  EXPECT_EQ(info["message_count"].as<int>(), 2);
  EXPECT_EQ(info["relative_file_paths"][0].as<std::string>(), "drive_0" + ending_);
  EXPECT_TRUE(fs::exists(folder_ / ("drive_0" + ending_)));
  const auto topic = info["topics_with_message_count"][1];
  EXPECT_EQ(topic["message_count"].as<int>(), 1);
  EXPECT_EQ(topic["topic_metadata"]["name"].as<std::string>(), "/map");
  YAML::Node qos = topic["topic_metadata"]["offered_qos_profiles"];
  if (!is_mcap_) qos = YAML::Load(qos.as<std::string>());
  EXPECT_EQ(qos[0]["durability"].as<std::string>(), is_mcap_ ? "transient_local" : "1");
  EXPECT_EQ(qos[0]["lifespan"]["sec"].as<std::int64_t>(), 9223372036);
}

TEST_P(Bag, KeepsWhatWasCommittedWhenItsProcessDies) {
  const pid_t child = fork();
  if (child == 0) {
    BagWriter writer{folder_, GetParam()};
    const int topic = writer.add_topic(kCommand);
    writer.write(topic, 1, {1});
    writer.commit();
    writer.write(topic, 2, {2});
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(read(folder_).size(), 1U);
  EXPECT_TRUE(fs::exists(folder_ / "metadata.yaml"));
}

TEST_P(Bag, StillBeingWrittenIsReadWithTheTopicsItHadWhenOpened) {
  BagWriter writer{folder_, GetParam()};
  const int command = writer.add_topic(kCommand);
  writer.write(command, 1, {1});
  writer.commit();
  BagReader reader{folder_};
  writer.write(writer.add_topic(kMap), 2, {2});
  writer.write(command, 3, {3});
  writer.commit();
  std::vector<std::int64_t> times;
  for (BagMessage message; reader.next(message);) times.push_back(message.time);
  EXPECT_EQ(times, is_mcap_ ? std::vector<std::int64_t>{1} : (std::vector<std::int64_t>{1, 3}));
  EXPECT_EQ(reader.topics().size(), 1U);
}

TEST_P(Bag, IsNeverWrittenOver) {
  { BagWriter writer{folder_, GetParam()}; }
  EXPECT_THROW((BagWriter{folder_, GetParam()}), std::runtime_error);
}

TEST_P(Bag, RefusesFilesThatAreNotBags) {
  fs::create_directory(folder_);
  EXPECT_THROW(BagReader{folder_}, std::runtime_error);
  std::ofstream{folder_ / ("x" + ending_)} << "no database, but long enough to be looked at as one";
  EXPECT_THROW(BagReader{folder_}, std::runtime_error);
  EXPECT_THROW(BagReader{root_ / ("missing" + ending_)}, std::runtime_error);
}

TEST_P(Bag, OfSqliteTruncatedIsRefusedWithARecoveryCommand) {
  if (is_mcap_) return;  // what is left of such a file is read: mcap_reader_test.cpp
  {
    BagWriter writer{folder_, GetParam()};
    const int command = writer.add_topic(kCommand);
    for (int i = 0; i < 1000; ++i) writer.write(command, i, std::vector<std::uint8_t>(100, 7));
  }
  const std::string file = folder_ / "drive_0.db3";
  fs::resize_file(file, fs::file_size(file) / 2);
  try {
    (void)read(folder_);
    FAIL() << "half of it was taken for all";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string{error.what()}.find(file), std::string::npos) << error.what();
    EXPECT_NE(std::string{error.what()}.find(".recover"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tandem
