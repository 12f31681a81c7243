// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/replay.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>

#include "bringup/bag/bag.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/runtime/decode.hpp"

namespace tandem {
namespace {

using Sticks = std::map<std::string, Recording>;  // by full topic name

bool is_called(const std::string& topic, const std::string& name) {
  return topic.ends_with("/" + name);
}

// The axis value that commands this speed.
double axis(double speed, double scale) {
  return scale == 0.0 ? 0.0 : std::clamp(speed / scale, -1.0, 1.0);
}

std::optional<Stick> stick_of(const sensor_msgs::msg::Joy& msg, const TeleopParams& teleop) {
  const Stick stick = read_stick(msg.axes(), msg.buttons(), teleop);
  return stick.deadman ? stick : Stick{};
}

std::optional<Stick> stick_of(const geometry_msgs::msg::Twist& msg, const TeleopParams& teleop) {
  const auto twist = from_msg(msg);
  if (!twist) return std::nullopt;
  return Stick{axis(twist->v, teleop.gains.scale_linear),
               axis(twist->w, teleop.gains.scale_angular), true, false};
}

// The stick position in a message of this type; empty if the bytes are not of the type.
template <class M>
std::optional<Stick> read_as(const std::vector<std::uint8_t>& bytes, const TeleopParams& teleop) {
  M msg;
  if (!rt::decode(rt::type_ref<M>(), bytes, &msg)) return std::nullopt;
  if constexpr (std::is_same_v<M, geometry_msgs::msg::TwistStamped>)
    return stick_of(msg.twist(), teleop);
  else
    return stick_of(msg, teleop);
}

std::optional<Stick> stick_in(const BagMessage& message, const std::string& type,
                              const TeleopParams& teleop) {
  if (type == "sensor_msgs/msg/Joy") return read_as<sensor_msgs::msg::Joy>(message.bytes, teleop);
  if (type == "geometry_msgs/msg/Twist")
    return read_as<geometry_msgs::msg::Twist>(message.bytes, teleop);
  if (type == "geometry_msgs/msg/TwistStamped")
    return read_as<geometry_msgs::msg::TwistStamped>(message.bytes, teleop);
  return std::nullopt;
}

// The storages would report any other file as damaged.
void require_recording(const std::string& path) {
  if (!is_recording(path))
    throw std::runtime_error(path +
                             ": not a recording; expected a folder written by `tandem record` or "
                             "rosbag2, or its .mcap or .db3");
}

// The joystick recording of every topic that contains one.
Sticks sticks_in(const std::string& path, const TeleopParams& teleop) {
  require_recording(path);
  BagReader bag{path};
  std::map<std::string, std::int64_t> first;
  Sticks sticks;
  for (BagMessage message; bag.next(message);) {
    const BagTopic& from = bag.topics().at(message.topic);
    const auto stick = stick_in(message, from.type, teleop);
    if (!stick) continue;
    const std::int64_t start = first.try_emplace(from.name, message.time).first->second;
    Recording& recording = sticks[from.name];
    recording.t.push_back(1e-9 * static_cast<double>(message.time - start));
    recording.linear.push_back(stick->linear);
    recording.angular.push_back(stick->angular);
  }
  return sticks;
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

Recording recorded_stick(const std::string& path, const TeleopParams& teleop,
                         const std::string& topic) {
  const Sticks sticks = sticks_in(path, teleop);
  if (const auto it = sticks.find(topic); it != sticks.end()) return it->second;
  std::vector<std::string> all, called;
  for (const auto& [name, stick] : sticks) all.push_back(name);
  if (!topic.empty())
    throw std::runtime_error(path + ": contains no joystick input on " + topic +
                             (all.empty() ? "" : "; there is some on " + listed(all)));
  for (const char* name : {"joy", "cmd_vel_user"}) {
    std::copy_if(all.begin(), all.end(), std::back_inserter(called),
                 [&](const auto& full) { return is_called(full, name); });
    if (called.size() == 1) return sticks.at(called.front());
    if (called.size() > 1)  // for example one joystick for each of two robots
      throw std::runtime_error(path + ": contains joystick input on " + listed(called) +
                               "; select one with `recording_topic` or --recording-topic");
  }
  throw std::runtime_error(path + ": contains no joystick input; record joy or cmd_vel_user");
}

}  // namespace tandem
