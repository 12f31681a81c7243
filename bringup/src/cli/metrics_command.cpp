// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/metrics_command.hpp"

#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "bringup/bag/bag.hpp"
#include "bringup/drive/drive_observer.hpp"
#include "bringup/drive/summary_table.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "bringup/system/shared_files.hpp"
#include "tandem/driver/driver.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map_server/map_server_node.hpp"
#include "tandem/model/frame_tree.hpp"
#include "tandem/runtime/decode.hpp"
#include "tandem/runtime/log.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

struct MetricsRequest {
  std::string recording, scenario, method, driver, map, name_space, json;
  unsigned seed = 0;
};

bool is_same(const Grid& a, const Grid& b) {
  return a.resolution == b.resolution && a.origin == b.origin && a.width == b.width &&
         a.cells == b.cells;
}

// Messages whose last field, `reason_code`, is missing in older recordings.
template <class M>
concept HasReasonCode = requires(M& msg) {
  msg.reason_code();
};

template <class M>
bool decode_recorded(std::vector<std::uint8_t> bytes, M& message) {
  if (rt::decode(rt::type_ref<M>(), bytes, &message)) return true;
  if constexpr (HasReasonCode<M>) {
    bytes.push_back(0);
    return rt::decode(rt::type_ref<M>(), bytes, &message);
  }
  return false;
}

// Passes the messages of a recording to a DriveObserver, as drive_over_dds does with live messages.
class Replay {
 public:
  Replay(const MetricsRequest& request, const MapServerParams& map, DriveObserver& drive)
      : recording_{request.recording},
        bag_{request.recording},
        name_space_{request.name_space},
        map_{map},
        drive_{drive} {
    has_truth_ = find(topics::ground_truth.name) != nullptr;
    if (!has_truth_ && find(topics::odom.name) == nullptr)
      throw std::runtime_error(recording_ + ": contains neither " +
                               full(topics::ground_truth.name) + " nor " + full(topics::odom.name) +
                               hint());
    if (find(topics::cmd_vel_user.name) == nullptr && find(topics::planner_status.name) == nullptr)
      throw std::runtime_error(recording_ + ": contains no " + full(topics::cmd_vel_user.name) +
                               ", so there is no drive to measure" + hint());
    listen();
  }

  void run() {
    BagMessage message;
    while (!drive_.over() && bag_.next(message))
      if (const auto& read = readers_[message.topic]) read(message.bytes);
  }

 private:
  using Bytes = std::vector<std::uint8_t>;

  [[nodiscard]] std::string full(const std::string& topic) const {
    return topic.starts_with('/') ? topic : name_space_ + "/" + topic;
  }
  [[nodiscard]] std::string hint() const { return "; use --namespace for a robot in a namespace"; }

  [[nodiscard]] const BagTopic* find(const char* topic) const {
    for (const auto& recorded : bag_.topics())
      if (recorded.name == full(topic)) return &recorded;
    return nullptr;
  }

  // A topic name may be recorded with several types, so each type has a separate reader.
  template <class M, class Fn>
  void on(const rt::Topic<M>& topic, Fn fn) {
    for (std::size_t i = 0; i < bag_.topics().size(); ++i) {
      const BagTopic& recorded = bag_.topics()[i];
      if (recorded.name != full(topic.name) || recorded.type != rt::type_ref<M>().name) continue;
      readers_[i] = [fn](const Bytes& bytes) {
        M message;
        if (decode_recorded(bytes, message)) fn(message);
      };
    }
  }

  // Warns if the recorded map differs from the scenario's. Clearance and shortest path would be
  // wrong, and nothing else in the results would show it.
  void compare(const octomap_msgs::msg::Octomap& msg) const {
    const auto recorded =
        decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), true).tree;
    if (recorded && is_same(slice(*recorded, map_.slice), slice(*load_map(map_.map), map_.slice)))
      return;
    rt::Logger{"tandem"}.warn(
        "{}: the map recorded on {} differs from {}, which is used for the measures; select the "
        "drive's map with --seed or --map",
        recording_, full(topics::octomap_binary.name), map_.map);
  }

  void listen() {
    on(topics::collision, [this](const auto& msg) { drive_.on_collision(msg); });
    on(topics::octomap_binary, [this](const auto& msg) {
      if (!std::exchange(compared_, true)) compare(msg);
    });
    on(topics::cmd_vel_user, [this](const auto& msg) { drive_.on_user(msg); });
    on(rt::Topic<geometry_msgs::msg::TwistStamped>{topics::cmd_vel_user.name},
       [this](const auto& msg) { drive_.on_user(msg); });
    on(topics::leader_pose, [this](const auto& msg) { drive_.on_leader(msg); });
    on(topics::planner_status, [this](const auto& msg) { drive_.on_plan(msg); });
    on(topics::filter_status, [this](auto& msg) {
      if (from_msg(msg.reason_code()) == Reason::kNone)  // older recordings have the text alone
        msg.reason_code(to_msg(reason_in(msg.reason())));
      drive_.on_filter(msg);
    });
    if (has_truth_) {
      on(topics::ground_truth, [this](const auto& msg) {
        if (const auto truth = truth_from(msg, frames_.map))
          drive_.on_robot(*truth, rt::to_seconds(msg.header().stamp()));
      });
      return;
    }
    on(topics::tf, [this](const auto& msg) { learn(msg, false); });
    on(topics::tf_static, [this](const auto& msg) { learn(msg, true); });
    on(topics::odom, [this](const auto& msg) {
      const auto odometry = from_msg(msg);
      if (const auto X_MF = in_map(msg.header().frame_id()); X_MF && odometry)
        drive_.on_robot({compose(*X_MF, odometry->X), odometry->twist},
                        rt::to_seconds(msg.header().stamp()));
    });
  }

  void learn(const tf2_msgs::msg::TFMessage& msg, bool is_static) {
    for (const auto& transform : msg.transforms())
      if (const auto X_PC = from_msg(transform.transform())) {
        const FrameLink link{.parent = transform.header().frame_id(),
                             .child = transform.child_frame_id(),
                             .X_PC = *X_PC,
                             .stamp = {}};
        is_static ? tree_.set_static(link) : tree_.set(link);
      }
  }
  // Without a localizer, the frames map and odom coincide.
  [[nodiscard]] std::optional<Pose2> in_map(const std::string& frame) const {
    const auto name = frame.empty() ? bare_frame(frames_.odom) : bare_frame(frame);
    if (const auto X_MF = tree_.pose(frames_.map, name)) return in_plane(*X_MF);
    return name == bare_frame(frames_.odom) ? std::optional{Pose2{}} : std::nullopt;
  }

  std::string recording_;
  BagReader bag_;
  std::string name_space_;
  MapServerParams map_;  // the scenario's map, compared with the recorded one
  DriveObserver& drive_;
  bool has_truth_ = false, compared_ = false;
  std::map<std::size_t, std::function<void(const Bytes&)>> readers_;  // by index of the topic
  Frames frames_;
  FrameTree tree_;
};

// No topic carries the seed, and a wrong guess would measure against another world or goal.
void require_seed(const Scenario& scenario, const MetricsRequest& request) {
  const bool many_worlds = is_family(request.map.empty() ? scenario.map : request.map);
  if (request.seed != 0 || (!many_worlds && scenario.goals.empty())) return;
  throw std::invalid_argument(
      request.scenario + ": the seed determines " +
      (many_worlds ? "in which of its worlds" : "to which of its goals") +
      " the robot drove; give it with --seed (`seed` in a result of `tandem scenario` or `study`)");
}

DriveOptions options_of(const MetricsRequest& request) {
  DriveOptions options;
  options.method = request.method;
  options.seed = request.seed;
  options.map = request.map;
  options.driver = request.driver;
  // The recording of a replayed drive also contains the stick that was replayed.
  if (!request.driver.empty() && DriverName{request.driver}.driver == "replay")
    options.recording = request.recording;
  return options;
}

void run(const MetricsRequest& request) {
  const Scenario file = load_scenario(request.scenario);
  require_seed(file, request);
  const DriveOptions options = options_of(request);
  const Scenario scenario = with_options(file, options);
  check_robot(scenario);
  const System system = system_of(scenario, options);
  DriveObserver drive{scenario, system, drive_world(scenario, system)};
  Replay{request, parameters_of<MapServerParams>(system, "map_server"), drive}.run();
  if (!drive.driving())
    throw std::runtime_error(request.recording +
                             ": contains no drive; record cmd_vel_user (Twist or TwistStamped), or "
                             "planner/status for the method goal");
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
  auto request = std::make_shared<MetricsRequest>();
  command
      ->add_option("recording", request->recording,
                   "recording of `tandem record` or `ros2 bag record`")
      ->required()
      ->check(CLI::ExistingPath);
  command
      ->add_option("--scenario", request->scenario,
                   "scenario file, or name of one that comes with Tandem, which gives map, robot, "
                   "goal and time limit")
      ->required();
  command->add_option("--method", request->method,
                      "method's name in the result; default: the scenario's");
  command->add_option("--driver", request->driver,
                      "driver's name in the result, as in `tandem scenario`");
  command
      ->add_option("--seed", request->seed,
                   "seed of the drive; required if the scenario has several worlds or goals")
      ->check(CLI::PositiveNumber);
  command->add_option("--map", request->map,
                      "map of the drive, a file or the name of one that comes with Tandem, if it "
                      "was not the scenario's");
  command->add_option("--namespace", request->name_space, "namespace of the robot, as /a");
  command->add_option("--json", request->json, "also write the measures to this file");
  command->footer(
      "Measures that compare with other drives, such as time_ratio and barn_score, are null; see "
      "`tandem study`. The exit status reports only whether the drive could be measured.");
  command->callback([request] {
    request->scenario = find_file(request->scenario, "scenarios");
    if (!request->map.empty()) request->map = find_file(request->map, "maps");
    run(*request);
  });
}

}  // namespace tandem
