// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/diagnostics.hpp"

#include <string_view>
#include <utility>

#include "tandem/io/conversions.hpp"
#include "tandem/model/reasons.hpp"

namespace tandem {
namespace {

namespace level = diagnostic_msgs::msg::DiagnosticStatus_Constants;
using Status = diagnostic_msgs::msg::DiagnosticStatus;

constexpr const char* kOurs = "tandem";
constexpr std::size_t kMaxParts = 1000;

void add_value(Status& status, const char* key, const std::string& text) {
  if (text.empty()) return;
  diagnostic_msgs::msg::KeyValue value;
  value.key(key);
  value.value(text);
  status.values().push_back(std::move(value));
}

bool gives(const Status& status, std::string_view topic) {
  const std::string given = value_of(status, "gives");
  for (std::string_view rest = given; !rest.empty();) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == topic) return true;
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return false;
}

// The faulty node that publishes the topic; null if there is none.
const Status* unwell_giver(const Diagnoses& diagnoses, const std::string& topic) {
  if (topic.empty()) return nullptr;
  for (const auto& [name, status] : diagnoses)
    if (status.level() != level::OK && gives(status, topic)) return &status;
  return nullptr;
}

std::string base_name(const std::string& name) { return name.substr(name.rfind('/') + 1); }

}  // namespace

Diagnostics::Diagnostics(rt::Node& node, std::initializer_list<const char*> gives)
    : node_{node},
      out_{node.create_publisher(topics::diagnostics)},
      timer_{node.create_wall_timer(kPeriod, [this] { publish(); })} {
  for (const char* topic : gives) gives_ += (gives_.empty() ? "" : " ") + node.resolve(topic);
}

void Diagnostics::report_trouble(const std::string& message, const char* waits_for) {
  const std::string topic = *waits_for == '\0' ? std::string{} : node_.resolve(waits_for);
  report({.message = message, .remedy = remedy_for(message), .waits_for = topic});
}

void Diagnostics::report(Report next) {
  const bool news = next.well != last_.well || (!next.well && next.message != last_.message);
  last_ = std::move(next);
  if (news) publish();
}

void Diagnostics::publish() {
  Status status;
  status.name(node_.fully_qualified_name().substr(1));
  status.hardware_id(kOurs);
  status.level(last_.well ? level::OK : level::WARN);
  status.message(last_.message);
  add_value(status, "remedy", last_.remedy);
  add_value(status, "gives", gives_);
  add_value(status, "waits_for", last_.waits_for);
  diagnostic_msgs::msg::DiagnosticArray msg;
  msg.header(header(node_.stamp(), ""));
  msg.status().push_back(std::move(status));
  out_.publish(msg);
}

void add(Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticArray& msg) {
  for (const auto& status : msg.status())
    if (diagnoses.size() < kMaxParts || diagnoses.contains(status.name()))
      diagnoses[status.name()] = status;
}

std::string value_of(const Status& status, std::string_view key) {
  for (const auto& value : status.values())
    if (value.key() == key) return value.value();
  return {};
}

// At most one step per node, so that nodes waiting for each other cause no endless loop.
const Status& first_cause(const Diagnoses& diagnoses, const Status& of) {
  const Status* cause = &of;
  for (std::size_t step = 0; step < diagnoses.size(); ++step) {
    const Status* next = unwell_giver(diagnoses, value_of(*cause, "waits_for"));
    if (!next || next->name() == cause->name()) break;
    cause = next;
  }
  return *cause;
}

Causes::Causes(rt::Node& node)
    : node_{node},
      subscription_{node.create_subscription(topics::diagnostics, [this](const auto& msg) {
        add(diagnoses_, msg);
        // Otherwise the node could name itself as the cause.
        diagnoses_.erase(node_.fully_qualified_name().substr(1));
        for (const auto& status : msg.status())
          if (diagnoses_.contains(status.name())) received_[status.name()] = node_.steady_now();
      })} {}

void Causes::forget_those_gone() {
  std::erase_if(received_, [this](const auto& entry) {
    return node_.steady_now() - entry.second > kNodeTimeout && diagnoses_.erase(entry.first) > 0;
  });
}

std::optional<Causes::Cause> Causes::behind(const char* topic) {
  forget_those_gone();
  const Status* start = unwell_giver(diagnoses_, node_.resolve(topic));
  if (!start) return std::nullopt;
  const Status& cause = first_cause(diagnoses_, *start);
  if (cause.name() == start->name()) return std::nullopt;
  return Cause{base_name(cause.name()) + ": " + cause.message(), value_of(cause, "remedy")};
}

}  // namespace tandem
