// SPDX-License-Identifier: Apache-2.0
// Compares the measures of a drive taken live and from its recording.
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/decode.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string scenario(const std::string& name) {
  return test::source_path("bringup/scenarios/" + name + ".yaml");
}

const std::string kScenario = scenario("forest_task2");

class MetricsProgram : public ::testing::Test {
 protected:
  MetricsProgram() { fs::create_directories(folder_); }
  ~MetricsProgram() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] json read(const std::string& name) const {
    std::ifstream in{file(name)};
    return json::parse(in);
  }
  static int run(const std::vector<std::string>& words) {
    test::ChildProcess program{"../tandem", words};
    return program.wait(150.0).value_or(-1);
  }

  // Drives and records it; then there are "live.json" and "bag".
  void drive(std::vector<std::string> words, const std::function<void(test::ChildProcess&)>& run) {
    words.insert(words.begin(), "scenario");
    words.insert(words.end(), {"--json", file("live.json")});
    test::ChildProcess record{"../tandem", {"record", "-o", file("bag")}};
    // From the first message on, however long a recorder takes to start.
    const double end = rt::steady_seconds() + 30.0;
    while (!fs::exists(file("bag"))) {
      ASSERT_LT(rt::steady_seconds(), end) << "nobody records";
      std::this_thread::yield();
    }
    test::ChildProcess program{"../tandem", words};
    run(program);
    record.send(SIGINT);
    ASSERT_EQ(record.wait(30.0), 0);
  }
  // The output of `tandem metrics` for a recording.
  json measure(std::vector<std::string> words, const std::string& bag = "bag") {
    words.insert(words.begin(), {"metrics", file(bag)});
    words.insert(words.end(), {"--json", file("recorded.json")});
    EXPECT_EQ(run(words), 0);
    return read("recorded.json");
  }

  fs::path folder_ = fs::temp_directory_path() / ("tandem_metrics_" + std::to_string(getpid()));
};

// The recording hears the same messages, the first ones and the last ones a moment apart; where a
// sanitizer watches the drive's first seconds may be lost to it, until it has found the topics.
void expect_alike(const json& live, const json& recorded) {
  for (const char* key : {"scenario", "map", "method", "driver", "seed", "reached", "collisions"})
    EXPECT_EQ(live.at(key), recorded.at(key)) << key;
  const std::vector<std::pair<const char*, double>> tolerances{
      {"time_to_goal_s", 0.5},          {"path_length_m", 0.1},
      {"min_clearance_m", 0.01},        {"mean_clearance_m", 0.05},
      {"agreement_direction", 0.05},    {"agreement_magnitude", 0.05},
      {"final_position_error_m", 0.05}, {"filter_commands", 20.0}};
  for (const auto& [key, tolerance] : tolerances)
    EXPECT_NEAR(live.at(key).get<double>(), recorded.at(key).get<double>(), tolerance) << key;
}

// As it was written before messages of this type had a reason_code, their last field.
template <class M>
void drop_code(std::vector<std::uint8_t>& bytes) {
  M message;
  ASSERT_TRUE(rt::decode(rt::type_ref<M>(), bytes, &message));
  ASSERT_TRUE(
      rt::Codec{rt::type_ref<M>()}.encode(&message, bytes));  // without the sender's padding
  bytes.pop_back();
  ASSERT_FALSE(rt::decode(rt::type_ref<M>(), bytes, &message));
}

void copy_without_codes(const std::string& from, const std::string& to, BagStorage storage) {
  BagReader in{from};
  BagWriter out{to, storage};
  std::vector<int> ids;
  for (const BagTopic& topic : in.topics()) ids.push_back(out.add_topic(topic));
  int shortened = 0;
  for (BagMessage message; in.next(message);) {
    const std::string& type = in.topics()[message.topic].type;
    shortened += type == "tandem_msgs/msg/FilterStatus" ? 1 : 0;
    if (type == "tandem_msgs/msg/FilterStatus")
      drop_code<tandem_msgs::msg::FilterStatus>(message.bytes);
    if (type == "tandem_msgs/msg/PlannerStatus")
      drop_code<tandem_msgs::msg::PlannerStatus>(message.bytes);
    out.write(ids[message.topic], message.time, message.bytes);
  }
  EXPECT_GT(shortened, 0);
}

double per_second(const json& result, const char* key) {
  return result.at(key).get<double>() / result.at("simulated_s").get<double>();
}

TEST_F(MetricsProgram, MeasuresARecordingAsTheDriveWasMeasured) {
  drive({kScenario, "--method", "safety_filter"},
        [](auto& program) { ASSERT_EQ(program.wait(150.0), 0); });
  const json recorded = measure({"--scenario", kScenario, "--method", "safety_filter"});
  const json live = read("live.json").at(0);
  expect_alike(live, recorded);
  EXPECT_NEAR(live.at("path_ratio").get<double>(), recorded.at("path_ratio").get<double>(), 0.02);

  // As often in each, however often the filter speaks; over DDS a late word is missed now and then.
  ASSERT_EQ(run({"scenario", kScenario, "--method", "safety_filter", "--lockstep", "--json",
                 file("lockstep.json")}),
            0);
  EXPECT_NEAR(per_second(read("lockstep.json").at(0), "filter_commands"), 20.0, 0.2);
  EXPECT_NEAR(per_second(live, "filter_commands"), 20.0, 3.0);

  for (const BagStorage storage : {BagStorage::kMcap, BagStorage::kSqlite}) {
    copy_without_codes(file("bag"), file(name(storage)), storage);
    EXPECT_EQ(measure({"--scenario", kScenario, "--method", "safety_filter"}, name(storage)),
              recorded)
        << name(storage);
  }
  EXPECT_EQ(run({"metrics", file("bag"), "--scenario", "forest_task2"}), 0);
}

TEST_F(MetricsProgram, MeasuresInTheWorldThatBelongsToTheSeed) {
  const std::string clutter = scenario("clutter");
  drive({clutter, "--seed", "3"},
        [](auto& program) { ASSERT_TRUE(program.wait(150.0).has_value()); });
  const test::CapturedLog log;
  const json live = read("live.json").at(0);
  const json recorded = measure({"--scenario", clutter, "--seed", "3"});
  EXPECT_EQ(live.at("seed"), recorded.at("seed"));
  // What the world says; in that of seed 1 the robot drives through things.
  EXPECT_NEAR(live.at("min_clearance_m"), recorded.at("min_clearance_m"), 0.02);
  EXPECT_GT(live.at("min_clearance_m"), 0.05);
  EXPECT_EQ(log.lines("--seed"), 0) << log.text();
  (void)measure({"--scenario", clutter, "--seed", "1"});
  EXPECT_EQ(log.lines("select the drive's map with --seed"), 1) << log.text();
  EXPECT_EQ(run({"metrics", file("bag"), "--scenario", clutter}), 1);
  EXPECT_EQ(run({"metrics", file("bag"), "--scenario", scenario("ward_goals")}), 1);
  EXPECT_EQ(log.lines("give it with --seed"), 2) << log.text();
}

// Nobody but the stamped command steers: the planner goes to the goal by itself. The drive ends a
// dozen plans after all who read the command have found it: the recorder, arbitration, the planner
// and the measures.
TEST_F(MetricsProgram, AcceptsStampedCommandsOfThePerson) {
  rt::Node person{"person"};
  const auto user = person.create_publisher(
      rt::Topic<geometry_msgs::msg::TwistStamped>{topics::cmd_vel_user.name, topics::kCommand});
  const auto end = person.create_publisher(topics::end_sim);
  std::uint64_t cycles_heard = 0;
  const auto planner = person.create_subscription(
      topics::planner_status, [&](const auto&) { cycles_heard += user.matched() < 4 ? 0 : 1; });
  const auto push = person.create_wall_timer(0.05, [&] {
    geometry_msgs::msg::TwistStamped msg;
    msg.header().stamp(person.stamp());
    msg.twist(to_msg(Twist2{0.5, 0.0}));
    user.publish(msg);
    std_msgs::msg::Bool over;
    over.data(true);
    if (cycles_heard > 12) end.publish(over);
  });
  drive({scenario("table_3_1")}, [&](auto& program) {
    ASSERT_TRUE(test::spin_until([&] { return program.wait(0.0).has_value(); }, 60.0, person))
        << "matched: " << user.matched();
  });
  EXPECT_TRUE(read("live.json").at(0).at("agreement_magnitude").is_number());
  const json recorded = measure({"--scenario", scenario("table_3_1"), "--method", "safety_filter"});
  EXPECT_TRUE(recorded.at("agreement_magnitude").is_number());
}

TEST_F(MetricsProgram, ErrorsNameWhatIsWrongWithARecording) {
  const test::CapturedLog log;
  int errors = 0;
  for (const char* none : {"none.db3", "none.mcap"}) {
    std::ofstream{file(none)} << "no recording";
    EXPECT_EQ(run({"metrics", file(none), "--scenario", kScenario}), 1);
    EXPECT_EQ(log.lines("tandem: "), ++errors) << log.text();
  }
  EXPECT_EQ(run({"metrics", "/nowhere", "--scenario", kScenario}), 1);
  EXPECT_EQ(run({"metrics", file("none.mcap"), "--scenario", "forest_task9"}), 1);
  EXPECT_EQ(log.lines("forest_task9"), 1) << log.text();
}

}  // namespace
}  // namespace tandem
