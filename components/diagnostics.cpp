// SPDX-License-Identifier: Apache-2.0
#include "diagnostics.hpp"

#include "convert.hpp"

namespace tandem {

Diagnostics::Diagnostics(rt::Node& node)
    : node_{node},
      out_{node.create_publisher(topics::diagnostics)},
      timer_{node.create_wall_timer(kPeriod, [this] { publish(); })} {}

void Diagnostics::say(bool well, const std::string& message, const std::string& remedy) {
  const bool news = well != well_ || (!well && message != message_);
  well_ = well;
  message_ = message;
  remedy_ = remedy;
  if (news) publish();
}

void Diagnostics::publish() {
  using namespace diagnostic_msgs::msg::DiagnosticStatus_Constants;
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.name(node_.fully_qualified_name().substr(1));
  status.hardware_id("tandem");
  status.level(well_ ? OK : WARN);
  status.message(message_);
  if (!remedy_.empty()) {
    diagnostic_msgs::msg::KeyValue value;
    value.key("remedy");
    value.value(remedy_);
    status.values().push_back(std::move(value));
  }
  diagnostic_msgs::msg::DiagnosticArray msg;
  msg.header(header(node_.stamp(), ""));
  msg.status().push_back(std::move(status));
  out_.publish(msg);
}

}  // namespace tandem
