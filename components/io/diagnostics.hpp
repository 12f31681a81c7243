// SPDX-License-Identifier: Apache-2.0
// Publishes a node's health on /diagnostics, and follows what nodes say there to the first cause.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// What a node says of itself on /diagnostics: every second, and a trouble at once when it comes,
/// changes or goes. Beside the message stand the values `remedy` (from the table of reasons.hpp),
/// `gives` (the topics that suffer if the node is unwell) and `waits_for` (the topic that it
/// lacks).
class Diagnostics {
 public:
  static constexpr double kPeriod = 1.0;  // [s]

  /// `gives`: topics that the node publishes, by their names in topics.hpp.
  Diagnostics(rt::Node& node, std::initializer_list<const char*> gives);
  Diagnostics(const Diagnostics&) = delete;
  Diagnostics& operator=(const Diagnostics&) = delete;

  /// All is well (level OK), or as well as it can be while nobody wants anything.
  void report_well(const std::string& message) { report({.well = true, .message = message}); }
  /// Something is wrong (level WARN). `waits_for`: the topic whose silence it is due to; empty if
  /// it is not due to another node.
  void report_trouble(const std::string& message, const char* waits_for = "");
  /// The same, with a cause that another node gave, and its remedy.
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

/// The last word of each part of each node on /diagnostics, by the part's name.
using Diagnoses = std::map<std::string, diagnostic_msgs::msg::DiagnosticStatus>;

/// Adds what a message says. Of more than a thousand parts, further ones are not kept.
void add(Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticArray& msg);

/// A value of a status; empty if it has none of that key.
[[nodiscard]] std::string value_of(const diagnostic_msgs::msg::DiagnosticStatus& status,
                                   std::string_view key);

/// The first cause of an unwell node's trouble: the node that gives what it waits for, if that is
/// unwell too, and so on; `of` itself if there is none.
[[nodiscard]] const diagnostic_msgs::msg::DiagnosticStatus& first_cause(
    const Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticStatus& of);

/// Subscribes /diagnostics for a node that says why the robot stands. What the node itself says
/// there is no cause.
class Causes {
 public:
  /// Words older than this [s] come from a node that is gone.
  static constexpr double kGone = 3.0 * Diagnostics::kPeriod;

  struct Cause {
    std::string reason;  ///< "node: what it said"
    std::string remedy;
  };

  explicit Causes(rt::Node& node);
  Causes(const Causes&) = delete;
  Causes& operator=(const Causes&) = delete;

  /// Another node's trouble, to which that of the node which gives `topic` is due; nothing if there
  /// is none.
  [[nodiscard]] std::optional<Cause> behind(const char* topic);

 private:
  void forget_those_gone();

  rt::Node& node_;
  Diagnoses diagnoses_;
  std::map<std::string, double> heard_;  // steady [s], by the part's name
  rt::Subscription subscription_;
};

}  // namespace tandem
