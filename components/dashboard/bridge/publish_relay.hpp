// SPDX-License-Identifier: Apache-2.0
// Publishes web clients' messages on the domain if they are valid and permitted.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// The few topics that web clients may publish. None of them bypasses the safety filter.
class PublishRelay {
 public:
  static constexpr std::size_t kMaxChannels = 100;  // of one client

  /// Result for one message.
  enum class Outcome { kPublished, kNoChannel, kOtherDrives, kMalformed, kOld };
  [[nodiscard]] static const char* text(Outcome outcome);

  /// A stick sample with a stamp older than `max_age` [s] is not published; 0: any age.
  PublishRelay(rt::Node& node, double max_age);
  /// The topics that it opens.
  [[nodiscard]] static rt::Interface interface();

  /// Returns an error message for the client, at most one per frame; empty on success.
  [[nodiscard]] std::string advertise(ClientId client, const foxglove::Advertise& request);
  void unadvertise(ClientId client, const foxglove::Unadvertise& request);
  void forget(ClientId client) { channels_.erase(client); }
  /// Prefixes of the client's frames that carry the emergency stop.
  [[nodiscard]] std::vector<std::string> urgent_prefixes(ClientId client) const;

  /// `may_drive` is called only for topics that move the robot.
  [[nodiscard]] Outcome publish(ClientId client, const foxglove::Message& message,
                                const std::function<bool()>& may_drive);
  /// Opens a JSON channel that the dashboard handles itself; `take` returns the result for a
  /// message.
  void open_own(const std::string& topic, const std::string& type,
                std::function<Outcome(ClientId, const std::vector<std::uint8_t>&)> take);
  /// Publishes a released stick for a driver who has disconnected.
  void release_stick();

 private:
  struct InputTopic {
    std::string type;
    bool drives;
    std::function<Outcome(ClientId, const std::vector<std::uint8_t>&)> publish;
    std::string encoding = "cdr";
    bool urgent = false;
  };

  template <class M>
  void open(const rt::Topic<M>& topic, bool drives);
  [[nodiscard]] std::string advertise(std::map<std::uint32_t, const InputTopic*>& channels,
                                      const foxglove::Advertise::One& wanted);
  [[nodiscard]] Outcome publish_joy(const std::vector<std::uint8_t>& bytes);
  [[nodiscard]] Outcome publish_stop(const std::vector<std::uint8_t>& bytes);

  rt::Node& node_;
  double max_age_;
  std::string namespace_;  // "" or "/a"
  std::map<std::string, InputTopic> inputs_;
  std::map<ClientId, std::map<std::uint32_t, const InputTopic*>> channels_;
  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  std::optional<rt::Publisher<std_msgs::msg::Bool>> stop_;
  bool stop_pressed_ = false;
};

}  // namespace tandem
