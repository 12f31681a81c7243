// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/guard_report.hpp"

#include <algorithm>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

namespace level = diagnostic_msgs::msg::DiagnosticStatus_Constants;
using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::KeyValue;

constexpr double kPeriod = 1.0;           // [s] between status messages
constexpr std::size_t kTotals = 2;        // number of values always present
constexpr std::size_t kMaxInAReport = 8;  // entries in the message; the values hold all

KeyValue value(const std::string& key, const std::string& text) {
  KeyValue pair;
  pair.key(key);
  pair.value(text);
  return pair;
}

// The drops counted since `before`, most frequent first.
std::vector<DropCount> news(std::vector<DropCount> now, const std::vector<DropCount>& before) {
  for (const auto& old : before)
    for (auto& drop : now)
      if (drop.drop == old.drop && drop.source == old.source) drop.count -= old.count;
  std::erase_if(now, [](const DropCount& drop) { return drop.count == 0; });
  std::sort(now.begin(), now.end(),
            [](const DropCount& a, const DropCount& b) { return a.count > b.count; });
  return now;
}

}  // namespace

GuardReport::GuardReport(DdsNode& node) : node_{node} {
  status_.name(node.full_name.substr(1) + ": network");
  status_.hardware_id("tandem");
}

GuardReport::~GuardReport() {
  guard_.release_report(this);
  if (writer_) node_.close_writer(*writer_);
}

double GuardReport::poll(double now) {
  if (guard_.dropped() == 0) return now + kPeriod;
  WireGuard::Reported* reported = guard_.claim_report(this);
  if (reported == nullptr) return now + kPeriod;
  if (now >= reported->next && guard_.dropped() != reported->count) {
    report(*reported);
    reported->next = now + kEvery;
  } else if (now >= reported->next) {
    status_.level(level::OK);
    status_.message("no datagram was dropped in the last minute");
  }
  // The message is empty if another node reported the drops.
  if (!status_.message().empty() && !refused_) publish();
  return now + kPeriod;
}

void GuardReport::report(WireGuard::Reported& reported) {
  const std::uint64_t count = guard_.dropped();
  auto drops = guard_.drops();
  auto fresh = news(drops, reported.drops);
  if (fresh.size() > kMaxInAReport) fresh.resize(kMaxInAReport);
  status_.level(level::WARN);
  status_.message(
      fmt::format("dropped {} datagrams, or parts of them, that were malformed or too frequent: {}",
                  count - reported.count, summary(fresh)));
  status_.values().resize(kTotals);
  status_.values().push_back(
      value("remedy",
            "find the program at that address and stop it, or check the link if it is a robot of "
            "yours; keep robots on a separate network"));
  for (const auto& drop : drops)
    status_.values().push_back(
        value(fmt::format("{} from {}", name(drop.drop), drop.source), std::to_string(drop.count)));
  node_.log.warn("{}", status_.message());
  reported.drops = std::move(drops);
  reported.count = count;
}

void GuardReport::publish() {
  if (!writer_) {
    codec_ = std::make_shared<Codec>(type_ref<DiagnosticArray>());
    try {
      writer_ = node_.open_writer({dds_topic_name(every_node::diagnostics.name), codec_->dds_name(),
                                   every_node::diagnostics.qos});
    } catch (const std::runtime_error& error) {  // a datagram must not terminate the process
      node_.log.warn("dropped datagrams are reported in this log only, not on /diagnostics: {}",
                     error.what());
      refused_ = true;
      return;
    }
  }
  status_.values().resize(std::max(kTotals, status_.values().size()));
  status_.values()[0] = value("received", std::to_string(guard_.received()));
  status_.values()[1] = value("dropped", std::to_string(guard_.dropped()));
  DiagnosticArray message;
  message.header().stamp(node_.stamp());
  message.status().push_back(status_);
  Bytes bytes;
  if (codec_->encode(&message, bytes)) (void)writer_->write(bytes);
}

}  // namespace tandem::runtime
