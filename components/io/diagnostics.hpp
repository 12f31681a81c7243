// SPDX-License-Identifier: Apache-2.0
// Publishes a node's health on /diagnostics, and traces the reports of all nodes to the first
// cause.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Publishes a node's status on /diagnostics every second, and immediately when a fault appears,
/// changes or ends. Besides the message it has the values `remedy` (from the table in reasons.hpp),
/// `gives` (the topics affected by a fault) and `waits_for` (the missing input topic).
class Diagnostics {
 public:
  static constexpr double kPeriod = 1.0;  ///< between two reports [s]

  /// `gives`: topics that the node publishes, by their names in topics.hpp.
  Diagnostics(rt::Node& node, std::initializer_list<const char*> gives);
  /// The topic that it opens.
  [[nodiscard]] static rt::Interface interface() { return {.publishes = {topics::diagnostics}}; }
  Diagnostics(const Diagnostics&) = delete;
  Diagnostics& operator=(const Diagnostics&) = delete;

  /// The node works or is idle (level OK).
  void report_well(const std::string& message) { report({.well = true, .message = message}); }
  /// The node has a fault (level WARN). `waits_for`: the silent topic that causes it; empty if no
  /// other node causes it.
  void report_trouble(const std::string& message, const char* waits_for = "");
  /// Reports a fault with the cause and remedy that another node reported.
  void report_cause(const std::string& message, const std::string& remedy) {
    report({.message = message, .remedy = remedy});
  }

 private:
  struct Report {
    bool well = false;
    std::string message = "starting", remedy = {}, waits_for = {};
  };

  void report(Report next);
  void publish();

  rt::Node& node_;
  std::string gives_;
  Report last_;
  rt::Publisher<diagnostic_msgs::msg::DiagnosticArray> out_;
  rt::Timer timer_;
};

/// The last status of each part of each node on /diagnostics, by the part's name.
using Diagnoses = std::map<std::string, diagnostic_msgs::msg::DiagnosticStatus>;

/// Adds the statuses of a message. Keeps at most a thousand parts.
void add(Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticArray& msg);

/// A value of a status; empty if it has none of that key.
[[nodiscard]] std::string value_of(const diagnostic_msgs::msg::DiagnosticStatus& status,
                                   std::string_view key);

/// The first cause of a node's fault: follows `waits_for` to the faulty node that publishes the
/// topic, and so on; `of` itself if there is none.
[[nodiscard]] const diagnostic_msgs::msg::DiagnosticStatus& first_cause(
    const Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticStatus& of);

/// Subscribes to /diagnostics for a node that reports why the robot is stopped. Ignores the node's
/// own status.
class Causes {
 public:
  /// A node whose last status is older than this [s] counts as gone.
  static constexpr double kNodeTimeout = 3.0 * Diagnostics::kPeriod;

  /// A fault of another node.
  struct Cause {
    std::string reason;  ///< "node: message"
    std::string remedy;  ///< as the node gives it; may be empty
  };

  /// Subscribes at once; `node` must outlive this.
  explicit Causes(rt::Node& node);
  /// The topic that it opens.
  [[nodiscard]] static rt::Interface interface() { return {.subscribes = {topics::diagnostics}}; }
  Causes(const Causes&) = delete;
  Causes& operator=(const Causes&) = delete;

  /// The fault of another node that explains why `topic` is missing; nullopt if there is none.
  [[nodiscard]] std::optional<Cause> behind(const char* topic);

 private:
  void forget_those_gone();

  rt::Node& node_;
  Diagnoses diagnoses_;
  std::map<std::string, double> received_;  // last arrival [s], steady clock; key: part's name
  rt::Subscription subscription_;
};

}  // namespace tandem
