// SPDX-License-Identifier: Apache-2.0
#include "bringup/diagnoses.hpp"

#include <algorithm>

namespace tandem {
namespace {

namespace level = diagnostic_msgs::msg::DiagnosticStatus_Constants;
using Status = diagnostic_msgs::msg::DiagnosticStatus;

constexpr std::size_t kMostParts = 1000;

const char* level_name(const Status& status) {
  if (status.level() == level::ERROR) return "error";
  return status.level() == level::STALE ? "stale" : "warning";
}

bool repeats(const Status& status, const Status& cause) {
  return status.message().size() > cause.message().size() && !cause.message().empty() &&
         status.message().ends_with(": " + cause.message());
}

std::string remedy_of(const Status& status) {
  for (const auto& value : status.values())
    if (value.key() == "remedy" && !value.value().empty()) return value.value();
  return "see the log of that node";
}

}  // namespace

void add(Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticArray& msg) {
  for (const auto& status : msg.status())
    if (diagnoses.size() < kMostParts || diagnoses.contains(status.name()))
      diagnoses[status.name()] = status;
}

std::vector<Finding> examine(const Diagnoses& diagnoses) {
  std::vector<Status> unwell;
  for (const auto& [name, status] : diagnoses)
    if (status.level() != level::OK) unwell.push_back(status);
  std::stable_sort(unwell.begin(), unwell.end(), [](const Status& a, const Status& b) {
    return a.level() == level::ERROR && b.level() != level::ERROR;
  });
  std::vector<Finding> found;
  for (const auto& status : unwell) {
    const bool is_echo = std::any_of(unwell.begin(), unwell.end(),
                                     [&](const Status& other) { return repeats(status, other); });
    if (!is_echo)
      found.push_back({status.name() + " (" + level_name(status) + "): " + status.message(),
                       remedy_of(status)});
  }
  return found;
}

}  // namespace tandem
