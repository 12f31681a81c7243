// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/play_command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "tandem/runtime/arguments.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

constexpr double kDay = 86'400e9;  // [ns]
constexpr double kStep = 0.05;     // [s] longest wait between two checks for a stop

struct PlayRequest {
  std::string path;
  std::vector<std::string> topics;
  double rate = 1.0;
  double wait = 0.5;
  bool loop = false;
};

class Player {
 public:
  Player(rt::Node& node, const PlayRequest& request) : node_{node}, request_{request} {
    topics_ = BagReader{request.path}.topics();
    for (const auto& name : request.topics) {
      wanted_.push_back(rt::expand_name(name, {"/", "tandem_play"}));
      if (std::none_of(topics_.begin(), topics_.end(),
                       [&](const BagTopic& topic) { return topic.name == wanted_.back(); }))
        throw std::invalid_argument(request.path + ": contains no " + wanted_.back());
    }
    for (const auto& topic : topics_)
      publishers_.push_back(is_wanted(topic.name) ? publisher_of(topic) : std::nullopt);
  }

  // Plays the recording; returns the number of messages sent.
  long play() {
    wait(request_.wait, [this] { return all_matched(); });
    do {
      play_once();
    } while (request_.loop && !node_.stopped());
    return sent_;
  }

 private:
  [[nodiscard]] bool is_wanted(const std::string& topic) const {
    return wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), topic) != wanted_.end();
  }

  // A topic that cannot be published, for example because its name is invalid, is skipped.
  std::optional<rt::GenericPublisher> publisher_of(const BagTopic& topic) {
    try {
      return node_.create_generic_publisher(topic.name, topic.type, topic.qos);
    } catch (const std::exception& error) {
      node_.log().warn("cannot play {} [{}]: {}", topic.name, topic.type, error.what());
      return std::nullopt;
    }
  }

  // Whether every played topic has a matched subscription.
  [[nodiscard]] bool all_matched() const {
    return std::all_of(publishers_.begin(), publishers_.end(), [](const auto& publisher) {
      return !publisher || publisher->matched() > 0;
    });
  }

  template <class Done>
  void wait(double seconds, Done done) {
    const double end = node_.steady_now() + seconds;
    for (double left = seconds; left > 0.0 && !node_.stopped() && !done();
         left = end - node_.steady_now())
      node_.spin_some(std::min(left, kStep));
  }

  void play_once() {
    BagReader bag{request_.path};
    const double start = node_.steady_now();
    std::optional<std::int64_t> first;
    BagMessage message;
    while (!node_.stopped() && bag.next(message)) {
      if (!first) first = message.time;
      warn_of_gap(bag);
      const double due = start + 1e-9 * static_cast<double>(message.time - *first) / request_.rate;
      wait(due - node_.steady_now(), [] { return false; });
      if (node_.stopped()) return;
      if (!publishers_[message.topic]) continue;
      publishers_[message.topic]->publish(message.bytes);
      ++sent_;
    }
  }

  void warn_of_gap(const BagReader& bag) {
    if (bag.skipped() <= skipped_) return;
    skipped_ = bag.skipped();
    node_.log().warn(
        "skipping a gap of {:.1f} days in the timestamps: was the clock set meanwhile?",
        static_cast<double>(skipped_) / kDay);
  }

  rt::Node& node_;
  const PlayRequest& request_;
  std::vector<std::string> wanted_;
  std::vector<BagTopic> topics_;
  std::vector<std::optional<rt::GenericPublisher>> publishers_;  // by topic; empty if not played
  std::int64_t skipped_ = 0;                                     // [ns] in gaps, warned of so far
  long sent_ = 0;
};

void play(const PlayRequest& request, const std::vector<std::string>& ros_args) {
  const auto arguments = rt::parse_ros_arguments(ros_args);
  if (!arguments.rest.empty())
    throw std::invalid_argument("unknown argument '" + arguments.rest.front() + "'");
  rt::install_signal_handlers();
  rt::Node node{rt::with_arguments({.name = "tandem_play"}, arguments)};
  Player player{node, request};
  node.log().info("playing {}", request.path);
  std::printf("%ld messages sent\n", player.play());
}

}  // namespace

void add_play_command(CLI::App& app) {
  auto request = std::make_shared<PlayRequest>();
  auto* command =
      app.add_subcommand("play", "Play a recording of `tandem record` or `ros2 bag record`");
  command
      ->add_option(
          "recording", request->path,
          "folder of the recording, or one of its files (.mcap, .db3, or either with .zstd)")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--topics", request->topics, "topics to play; default: all");
  command->add_option("--rate", request->rate, "playing speed relative to the recording")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  command
      ->add_option("--wait", request->wait,
                   "[s] longest wait at the start for a subscription to every topic")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--loop", request->loop, "repeat until Ctrl-C");
  command->allow_extras();
  command->footer("Accepts ROS 2's --ros-args -r from:=to.");
  command->callback([request, command] { play(*request, command->remaining()); });
}

}  // namespace tandem
