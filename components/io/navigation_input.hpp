// SPDX-License-Identifier: Apache-2.0
// Subscribes to what arbitration and the safety filter report, for nodes that serve goals.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "tandem/model/navigation_check.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes to `arbitration/status` and `safety_filter/status`.
class NavigationInput {
 public:
  static constexpr double kSilence = 0.5;  ///< [s] after which a node counts as silent

  /// `node` must outlive this. All callbacks run on the node's thread.
  explicit NavigationInput(rt::Node& node);
  /// The topics that it opens.
  [[nodiscard]] static rt::Interface interface();
  NavigationInput(const NavigationInput&) = delete;
  NavigationInput& operator=(const NavigationInput&) = delete;

  /// Calls `fn` after each message of arbitration.
  void on_arbitration(std::function<void()> fn) { on_arbitration_ = std::move(fn); }

  /// What both report now. Method and pose are left to the caller.
  [[nodiscard]] NavigationState state() const;

 private:
  struct Arbitration {
    std::string policy;
    bool emergency_stop = false;
  };

  rt::Node& node_;
  Stamped<Arbitration> arbitration_;
  Stamped<bool> filter_enforces_;
  std::function<void()> on_arbitration_;
  rt::Subscription on_status_, on_filter_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
