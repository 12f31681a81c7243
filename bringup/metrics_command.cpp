// SPDX-License-Identifier: Apache-2.0
#include "bringup/metrics_command.hpp"

#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bringup/bag.hpp"
#include "bringup/drive_observer.hpp"
#include "bringup/report.hpp"
#include "runtime/decode.hpp"
#include "runtime/time.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

struct Request {
  std::string recording, scenario, method, name_space, json;
};

// Reads a recording as the monitor of a drive reads the bus.
class Replay {
 public:
  Replay(const std::string& recording, const std::string& name_space, DriveObserver& drive)
      : bag_{recording}, name_space_{name_space}, drive_{drive} {
    has_truth_ = find(topics::ground_truth.name) != nullptr;
    if (!has_truth_ && find(topics::odom.name) == nullptr)
      throw std::runtime_error(recording + ": neither " + full(topics::ground_truth.name) +
                               " nor " + full(topics::odom.name) + " is in it" + hint());
    if (find(topics::cmd_vel_user.name) == nullptr && find(topics::planner_status.name) == nullptr)
      throw std::runtime_error(recording + ": no " + full(topics::cmd_vel_user.name) +
                               " is in it, so nobody drives" + hint());
    listen();
  }

  void run() {
    BagMessage message;
    while (!drive_.over() && bag_.next(message)) {
      const auto& name = bag_.topics()[message.topic].name;
      if (const auto it = readers_.find(name); it != readers_.end()) it->second(message.bytes);
    }
  }

 private:
  using Bytes = std::vector<std::uint8_t>;

  [[nodiscard]] std::string full(const std::string& topic) const {
    return topic.starts_with('/') ? topic : name_space_ + "/" + topic;
  }
  [[nodiscard]] std::string hint() const { return "; --namespace names a robot's"; }

  [[nodiscard]] const BagTopic* find(const char* topic) const {
    for (const auto& recorded : bag_.topics())
      if (recorded.name == full(topic)) return &recorded;
    return nullptr;
  }

  template <class M, class Fn>
  void on(const rt::Topic<M>& topic, Fn fn) {
    const BagTopic* recorded = find(topic.name);
    if (recorded == nullptr || recorded->type != rt::type_ref<M>().name) return;
    readers_[recorded->name] = [fn](const Bytes& bytes) {
      M message;
      if (rt::decode(rt::type_ref<M>(), bytes, &message)) fn(message);
    };
  }

  void listen() {
    on(topics::collision, [this](const auto& msg) { drive_.on_collision(msg); });
    on(topics::cmd_vel_user, [this](const auto& msg) { drive_.on_user(msg); });
    on(topics::leader_pose, [this](const auto& msg) { drive_.on_leader(msg); });
    on(topics::planner_status, [this](const auto& msg) { drive_.on_plan(msg); });
    on(topics::filter_status, [this](const auto& msg) { drive_.on_filter(msg); });
    if (has_truth_) {
      on(topics::ground_truth, [this](const auto& msg) {
        if (const auto truth = from_msg(msg))
          drive_.on_robot(*truth, rt::to_seconds(msg.header().stamp()));
      });
      return;
    }
    on(topics::tf, [this](const auto& msg) {
      if (const auto X_MW = find_transform(msg, frames_.map, frames_.odom)) X_MW_ = *X_MW;
    });
    on(topics::odom, [this](const auto& msg) {
      if (const auto odometry = from_msg(msg))
        drive_.on_robot({compose(X_MW_, odometry->X), odometry->twist},
                        rt::to_seconds(msg.header().stamp()));
    });
  }

  BagReader bag_;
  std::string name_space_;
  DriveObserver& drive_;
  bool has_truth_ = false;
  std::map<std::string, std::function<void(const Bytes&)>> readers_;
  Frames frames_;
  Pose2 X_MW_;  // without a localiser the frames are one
};

void run(const Request& request) {
  DriveOptions options;
  options.method = request.method;
  const Scenario scenario = with_options(load_scenario(request.scenario), options);
  check_robot(scenario);
  DriveObserver drive{scenario, system_of(scenario, options)};
  Replay{request.recording, request.name_space, drive}.run();
  if (!drive.driving()) throw std::runtime_error(request.recording + ": nobody drives in it");
  const DriveResult result = drive.log().result;
  if (!request.json.empty()) {
    std::ofstream out{request.json};
    out << nlohmann::json(result).dump(2) << '\n';
    if (!out) throw std::runtime_error(request.json + ": cannot be written");
  }
  std::printf("%s%s\n", summary_table({result}).c_str(), nlohmann::json(result).dump(2).c_str());
}

}  // namespace

void add_metrics_command(CLI::App& app) {
  auto* command = app.add_subcommand("metrics", "Measure a drive from a recording");
  auto request = std::make_shared<Request>();
  command->add_option("recording", request->recording, "what `tandem record` or ros2 bag wrote")
      ->required()
      ->check(CLI::ExistingPath);
  command
      ->add_option("--scenario", request->scenario,
                   "scenario file: the map, the robot, the goal and the time allowed")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--method", request->method, "name in the result (default: the scenario's)");
  command->add_option("--namespace", request->name_space, "the robot's, as /a");
  command->add_option("--json", request->json, "write the measures to this file too");
  command->callback([request] { run(*request); });
}

}  // namespace tandem
