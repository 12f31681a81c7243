// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/rosout.hpp"

#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

using rcl_interfaces::msg::Log;

Log to_log(const LogLine& line, const NodeCore& node) {
  Log log;
  log.stamp(
      to_stamp(node.system_nanoseconds()));  // system time even under use_sim_time, as rcl does
  log.level(severity(line.level));
  log.name(node.log.name());
  log.msg(line.text);
  log.file(line.place.file);
  log.function(line.place.function);
  log.line(line.place.line);
  return log;
}

}  // namespace

std::uint8_t severity(LogLevel level) {
  namespace levels = rcl_interfaces::msg::LoggerLevel_Constants;
  switch (level) {
    case LogLevel::kDebug:
      return levels::LOG_LEVEL_DEBUG;
    case LogLevel::kInfo:
      return levels::LOG_LEVEL_INFO;
    case LogLevel::kWarn:
      return levels::LOG_LEVEL_WARN;
    case LogLevel::kError:
      return levels::LOG_LEVEL_ERROR;
    case LogLevel::kOff:
      return levels::LOG_LEVEL_FATAL;
  }
  return levels::LOG_LEVEL_FATAL;
}

RosOut::RosOut(NodeCore& node) : node_{node} {
  lines_ = node.open_publisher(every_node::rosout.name, type_ref<Log>(), every_node::rosout.qos);
  node.log.set_sink([&node, lines = lines_](const LogLine& line) {
    const Log log = to_log(line, node);
    (void)lines->publish(&log);
  });
}

RosOut::~RosOut() {
  node_.log.set_sink({});
  lines_->close();
}

}  // namespace tandem::runtime
