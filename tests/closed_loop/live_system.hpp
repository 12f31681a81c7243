// SPDX-License-Identifier: Apache-2.0
// The nodes of a robot that knows obstacles only from its scanner, on a local bus: simulator,
// octomap_builder and safety_filter. A test holds the stick, and may change what the sensors say.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "support/temporary_folder.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/grid.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/local_bus.hpp"

namespace tandem::test {

/// Writes the edge cells of a grid's obstacles as an octomap, in one layer 0.5 m above the floor.
inline void save_world(const Grid& grid, const std::string& file) {
  octomap::OcTree tree{grid.resolution};
  const auto is_occupied = [&](int ix, int iy) {
    return ix < 0 || iy < 0 || ix >= grid.width || iy >= grid.height ||
           grid.cells[grid.index(ix, iy)] == Cell::kOccupied;
  };
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      if (grid.cells[grid.index(ix, iy)] != Cell::kOccupied) continue;
      bool is_edge = false;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        is_edge = is_edge || !is_occupied(ix + dx, iy + dy);
      const Eigen::Vector2d p = grid.center(ix, iy);
      if (is_edge) tree.updateNode(p.x(), p.y(), 0.5, true, true);
    }
  tree.updateInnerOccupancy();
  save_octomap(tree, file);
}

class LiveSystem {
 public:
  using Values = std::map<std::string, std::string>;  ///< by parameter's name
  /// Topics that a relay of the test stands in.
  enum class Relayed { kNothing, kSensors };

  LiveSystem(const Grid& world, const Pose2& start, unsigned seed,
             std::map<std::string, Values> parameters, Relayed relayed = Relayed::kNothing)
      : parameters_{std::move(parameters)}, relayed_{relayed}, node_{options("test", {})} {
    save_world(world, (folder_.path() / "world.bt").string());
    stick_ = node_.create_publisher(topics::cmd_vel_arbitrated);
    auto& sim = parameters_["diff_drive_sim"];
    sim["map"] = (folder_.path() / "world.bt").string();
    sim["seed"] = fmt::format("{}", seed);
    sim["start"] = fmt::format("[{}, {}, {}]", start.x, start.y, start.theta);
    parameters_["safety_filter"]["map_source"] = "local";
    collision_ = node_.create_subscription(topics::collision,
                                           [this](const auto& msg) { contacts_ = msg.count(); });
    sensing_ = node_.create_subscription(topics::sensing_status,
                                         [this](const auto& msg) { trouble_ = msg.reason(); });
    ground_truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      t_ = rt::to_seconds(msg.header().stamp());
      if (const auto truth = truth_from(msg, Frames{}.map)) truth_ = *truth;
      if (on_truth) on_truth();
    });
    pushes_ = node_.create_wall_timer(0.04, [this] { stick_.publish(to_msg(wish_)); });
  }

  /// Starts the nodes. Before it, subscribe to what must not be missed.
  void start() {
    for (const char* name : {"diff_drive_sim", "octomap_builder", "safety_filter"})
      components_.push_back(rt::load_component(name, options(name, parameters_[name])));
  }

  /// Holds the stick for this long [s], or until `done`.
  void run(const Twist2& stick, double duration, const std::function<bool()>& done = {}) {
    wish_ = stick;
    if (done)
      bus_->run_until(done, duration);
    else
      bus_->run_for(duration);
  }

  [[nodiscard]] rt::Node& node() { return node_; }
  [[nodiscard]] double t() const { return t_; }  ///< [s] of the last ground truth
  [[nodiscard]] const Odometry& truth() const { return truth_; }
  [[nodiscard]] unsigned contacts() const { return contacts_; }
  /// Why the builder says that the robot must stand; empty if its sensors work.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

  std::function<void()> on_truth;  ///< called with each ground truth

 private:
  rt::NodeOptions options(const std::string& name, const Values& values) {
    rt::NodeOptions all;
    all.name = name;
    all.bus = bus_;
    all.serves_tools = false;
    all.log_level = rt::LogLevel::kOff;
    all.use_sim_time = name != "diff_drive_sim" && name != "test";
    for (const auto& [key, value] : values) all.parameters.values[key] = {value, "test"};
    if (name == "diff_drive_sim" && relayed_ == Relayed::kSensors)
      all.remappings = {{"scan", "true_scan"}, {"odom", "true_odom"}};
    return all;
  }

  TemporaryFolder folder_;
  std::shared_ptr<rt::LocalBus> bus_ = std::make_shared<rt::LocalBus>();
  std::map<std::string, Values> parameters_;  // by node's name
  Relayed relayed_;
  rt::Node node_;
  rt::Publisher<geometry_msgs::msg::Twist> stick_;
  Twist2 wish_;
  double t_ = 0.0;
  Odometry truth_;
  unsigned contacts_ = 0;
  std::string trouble_;
  rt::Subscription collision_, sensing_, ground_truth_;
  rt::Timer pushes_;
  std::vector<rt::RunningComponent> components_;
};

}  // namespace tandem::test
