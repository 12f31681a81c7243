// SPDX-License-Identifier: Apache-2.0
// In: how a node is. Out: the same on /diagnostics.
#pragma once

#include <string>

#include "runtime/node.hpp"
#include "topics.hpp"

namespace tandem {

/// What a node says of itself on /diagnostics: every second, and a trouble at once when it comes,
/// changes or goes.
class Diagnostics {
 public:
  static constexpr double kPeriod = 1.0;  // [s]

  explicit Diagnostics(rt::Node& node);
  Diagnostics(const Diagnostics&) = delete;
  Diagnostics& operator=(const Diagnostics&) = delete;

  /// `well`: level OK, else WARN. `remedy`: what would mend it; told as the value `remedy`.
  void say(bool well, const std::string& message, const std::string& remedy = "");

 private:
  void publish();

  rt::Node& node_;
  bool well_ = false;
  std::string message_ = "starting", remedy_;
  rt::Publisher<diagnostic_msgs::msg::DiagnosticArray> out_;
  rt::Timer timer_;
};

}  // namespace tandem
