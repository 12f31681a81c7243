// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/diagnoses.hpp"

#include <algorithm>

#include "tandem/model/reasons.hpp"

namespace tandem {
namespace {

namespace level = diagnostic_msgs::msg::DiagnosticStatus_Constants;
using Status = diagnostic_msgs::msg::DiagnosticStatus;

const char* level_name(const Status& status) {
  if (status.level() == level::ERROR) return "error";
  return status.level() == level::STALE ? "stale" : "warning";
}

bool repeats(const std::string& text, const std::string& cause) {
  return text.size() > cause.size() && !cause.empty() && text.ends_with(": " + cause);
}

std::string remedy_of(const Status& status) {
  const std::string remedy = value_of(status, "remedy");
  return remedy.empty() ? "see the log of that node" : remedy;
}

// Whether a status only repeats another node's status or a finding.
bool is_echo(const Status& status, const Diagnoses& diagnoses, const std::vector<Finding>& found) {
  if (first_cause(diagnoses, status).name() != status.name()) return true;
  for (const auto& [name, other] : diagnoses)
    if (other.level() != level::OK && repeats(status.message(), other.message())) return true;
  return std::any_of(found.begin(), found.end(), [&](const Finding& finding) {
    return finding.what.find(": " + status.message()) != std::string::npos;
  });
}

}  // namespace

std::vector<Finding> examine(const Diagnoses& diagnoses, const std::vector<Finding>& found) {
  std::vector<Status> unwell;
  for (const auto& [name, status] : diagnoses)
    if (status.level() != level::OK) unwell.push_back(status);
  std::stable_sort(unwell.begin(), unwell.end(), [](const Status& a, const Status& b) {
    return a.level() == level::ERROR && b.level() != level::ERROR;
  });
  std::vector<Finding> more;
  std::vector<Finding> all = found;
  for (const auto& status : unwell) {
    if (is_echo(status, diagnoses, all)) continue;
    const bool nobody_steers = status.message() == text_of(Reason::kUserSilent);
    more.push_back({status.name() + " (" + level_name(status) + "): " + status.message(),
                    remedy_of(status), nobody_steers});
    all.push_back(more.back());
  }
  return more;
}

}  // namespace tandem
