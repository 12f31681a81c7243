// SPDX-License-Identifier: Apache-2.0
#include "bringup/replay.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "bringup/bag.hpp"
#include "convert.hpp"
#include "runtime/decode.hpp"

namespace tandem {
namespace {

bool is_called(const BagTopic& topic, const std::string& name) {
  return topic.name == "/" + name || topic.name.ends_with("/" + name);
}

// The axis that makes this speed.
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

// What a message of this type says of the stick; nothing if it is not of the type.
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

Recording stick_from(const std::string& path, const std::string& topic,
                     const TeleopParams& teleop) {
  BagReader bag{path};
  Recording recording;
  std::optional<std::int64_t> first;
  for (BagMessage message; bag.next(message);) {
    const BagTopic& from = bag.topics().at(message.topic);
    if (!is_called(from, topic)) continue;
    const auto stick = stick_in(message, from.type, teleop);
    if (!stick) continue;
    if (!first) first = message.time;
    recording.t.push_back(1e-9 * static_cast<double>(message.time - *first));
    recording.linear.push_back(stick->linear);
    recording.angular.push_back(stick->angular);
  }
  return recording;
}

}  // namespace

Recording recorded_stick(const std::string& path, const TeleopParams& teleop) {
  for (const char* topic : {"joy", "cmd_vel_user"}) {
    Recording recording = stick_from(path, topic, teleop);
    if (!recording.t.empty()) return recording;
  }
  throw std::runtime_error(path + ": nobody is at the stick; record joy or cmd_vel_user");
}

}  // namespace tandem
