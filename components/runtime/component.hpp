// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/node.hpp"

namespace tandem::runtime {

using MakeComponent = std::shared_ptr<void> (*)(Node& node);

/// Registers a component under its name. Called by TANDEM_COMPONENT.
bool register_component(const char* name, MakeComponent make);

/// Use once, in one .cpp of libtandem_<name>.so:
/// `TANDEM_COMPONENT(tandem::SafetyFilterNode, "safety_filter")`.
#define TANDEM_COMPONENT(Type, component_name)                                                     \
  namespace {                                                                                      \
  [[maybe_unused]] const bool tandem_component_registered = ::tandem::runtime::register_component( \
      component_name, [](::tandem::runtime::Node& node) -> std::shared_ptr<void> {                 \
        return std::make_shared<Type>(node);                                                       \
      });                                                                                          \
  }

/// Folders searched for libtandem_<name>.so: those of TANDEM_COMPONENT_PATH, the folder of
/// libtandem_runtime.so, and tandem/ in that folder.
[[nodiscard]] std::vector<std::string> component_folders();
/// Names of the components that can be loaded.
[[nodiscard]] std::vector<std::string> list_components();

/// A component, its node and the thread that spins it. Destruction stops it.
class RunningComponent {
 public:
  /// Loads and constructs; spins only after start(). Throws std::invalid_argument for an unknown
  /// component (listing the components found in each folder) and whatever its constructor throws.
  RunningComponent(const std::string& component, NodeOptions options);
  ~RunningComponent();
  RunningComponent(RunningComponent&&) noexcept;
  RunningComponent& operator=(RunningComponent&&) noexcept;

  void start();
  void stop();  ///< returns at once
  void join();  ///< waits until it has stopped
  [[nodiscard]] Node& node() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Constructs and starts a component.
[[nodiscard]] RunningComponent load_component(const std::string& component, NodeOptions options);

}  // namespace tandem::runtime
