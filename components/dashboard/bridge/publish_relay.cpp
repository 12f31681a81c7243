// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/bridge/publish_relay.hpp"

#include <memory>

#include "tandem/dashboard/complaints.hpp"
#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

constexpr const char* kSender = "dashboard";  // the same for all web clients

// Lichtblick's panels write "geometry_msgs/Twist" for "geometry_msgs/msg/Twist".
std::string full_type(const std::string& type) {
  const auto slash = type.find('/');
  const bool is_short =
      slash != std::string::npos && type.find('/', slash + 1) == std::string::npos;
  return is_short ? type.substr(0, slash) + "/msg" + type.substr(slash) : type;
}

}  // namespace

const char* PublishRelay::text(Outcome outcome) {
  switch (outcome) {
    case Outcome::kPublished:
      return "published";
    case Outcome::kNoChannel:
      return "a message on a channel that was not advertised";
    case Outcome::kOtherDrives:
      return "someone else is driving";
    case Outcome::kMalformed:
      return "a message that is not of the channel's type";
    case Outcome::kOld:
      return "an outdated joystick message: the connection stalls, or the clocks differ";
  }
  return "?";
}

PublishRelay::PublishRelay(rt::Node& node, double max_age)
    : node_{node}, max_age_{max_age}, joy_{node.create_publisher(topics::joy)} {
  const auto& full = node.fully_qualified_name();
  namespace_ = full.substr(0, full.rfind('/'));
  inputs_[namespace_ + "/" + topics::joy.name] = {
      rt::type_ref<sensor_msgs::msg::Joy>().name, true,
      [this](ClientId, const auto& bytes) { return publish_joy(bytes); }};
  open(topics::cmd_vel_user, true);
  open(topics::goal_pose, true);
  open(topics::initial_pose, true);
  open(topics::end_sim, true);
  inputs_[namespace_ + "/" + topics::e_stop.name] = {
      // everybody may stop the robot
      rt::type_ref<std_msgs::msg::Bool>().name, false,
      [this](ClientId, const auto& bytes) { return publish_stop(bytes); }, "cdr", true};
}

rt::Interface PublishRelay::interface() {
  const char* once = "a web client publishes it";
  return {.publishes = {topics::joy,
                        {topics::cmd_vel_user, once},
                        {topics::goal_pose, once},
                        {topics::initial_pose, once},
                        {topics::end_sim, once},
                        {topics::e_stop, once}}};
}

template <class M>
void PublishRelay::open(const rt::Topic<M>& topic, bool drives) {
  // Created on first use, so that the graph shows no publisher that never publishes.
  auto publisher = std::make_shared<std::unique_ptr<rt::Publisher<M>>>();
  auto publish = [this, topic, publisher](ClientId, const std::vector<std::uint8_t>& bytes) {
    const auto message = rt::decode<M>(bytes);
    if (!message) return Outcome::kMalformed;
    if (!*publisher) *publisher = std::make_unique<rt::Publisher<M>>(node_.create_publisher(topic));
    (*publisher)->publish(*message);
    return Outcome::kPublished;
  };
  inputs_[namespace_ + "/" + topic.name] = {rt::type_ref<M>().name, drives, std::move(publish)};
}

void PublishRelay::open_own(
    const std::string& topic, const std::string& type,
    std::function<Outcome(ClientId, const std::vector<std::uint8_t>&)> take) {
  inputs_[topic] = {type, false, std::move(take), "json"};
}

std::string PublishRelay::advertise(ClientId client, const foxglove::Advertise& request) {
  Complaints complaints;
  for (const auto& one : request.all) complaints.add(advertise(channels_[client], one));
  return complaints.text();
}

std::string PublishRelay::advertise(std::map<std::uint32_t, const InputTopic*>& channels,
                                    const foxglove::Advertise::One& wanted) {
  const auto& [channel, topic, encoding, short_type] = wanted;
  const std::string type = encoding == "cdr" ? full_type(short_type) : short_type;
  const auto input = inputs_.find(topic.starts_with("/") ? topic : namespace_ + "/" + topic);
  if (input == inputs_.end()) return "web clients may not publish " + topic.substr(0, 100);
  if (encoding != input->second.encoding || type != input->second.type)
    return topic + " takes " + input->second.type + " in " + input->second.encoding;
  if (channels.size() >= kMaxChannels)
    return "at most " + std::to_string(kMaxChannels) + " channels";
  channels[channel] = &input->second;
  return {};
}

std::vector<std::string> PublishRelay::urgent_prefixes(ClientId client) const {
  std::vector<std::string> prefixes;
  if (const auto found = channels_.find(client); found != channels_.end())
    for (const auto& [channel, input] : found->second)
      if (input->urgent) prefixes.push_back(foxglove::message_prefix(channel));
  return prefixes;
}

void PublishRelay::unadvertise(ClientId client, const foxglove::Unadvertise& request) {
  for (const auto channel : request.channels) channels_[client].erase(channel);
}

PublishRelay::Outcome PublishRelay::publish(ClientId client, const foxglove::Message& message,
                                            const std::function<bool()>& may_drive) {
  const auto& channels = channels_[client];
  const auto channel = channels.find(message.channel);
  if (channel == channels.end()) return Outcome::kNoChannel;
  if (channel->second->drives && !may_drive()) return Outcome::kOtherDrives;
  return channel->second->publish(client, message.payload);
}

// A client stamps its stick with the newest time that it has received from here. Samples that a
// stalled connection delivers late, or that were steered by a frozen picture, are thus rejected as
// too old.
PublishRelay::Outcome PublishRelay::publish_joy(const std::vector<std::uint8_t>& bytes) {
  auto joy = rt::decode<sensor_msgs::msg::Joy>(bytes);
  if (!joy) return Outcome::kMalformed;
  const double stamp = rt::to_seconds(joy->header().stamp());
  const double age = 1e-9 * static_cast<double>(rt::system_nanoseconds()) - stamp;
  if (max_age_ > 0.0 && stamp > 0.0 && age > max_age_) return Outcome::kOld;
  joy->header().stamp(node_.stamp());
  joy->header().frame_id(kSender);
  joy_.publish(*joy);
  return Outcome::kPublished;
}

void PublishRelay::release_stick() {
  sensor_msgs::msg::Joy joy;
  joy.header().frame_id(kSender);
  joy_.publish(joy);
}

// `false` releases only a stop that was pressed here.
PublishRelay::Outcome PublishRelay::publish_stop(const std::vector<std::uint8_t>& bytes) {
  const auto stop = rt::decode<std_msgs::msg::Bool>(bytes);
  if (!stop) return Outcome::kMalformed;
  if (!stop->data() && !stop_pressed_) return Outcome::kPublished;
  if (!stop_) stop_.emplace(node_.create_publisher(topics::e_stop));
  stop_->publish(*stop);
  stop_pressed_ = stop->data();
  return Outcome::kPublished;
}

}  // namespace tandem
