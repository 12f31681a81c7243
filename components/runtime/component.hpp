// SPDX-License-Identifier: Apache-2.0
// The registry of components: how each is made, its parameters, topics and services, and which
// modules hold them.
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/interface.hpp"
#include "tandem/runtime/module_mark.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/parameter_fields.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A component as its module describes it. Parameter checks, permissions and `tandem describe` read
/// this.
struct ComponentDescription {
  std::string name;                  ///< as registered
  std::vector<Field> parameters{};   ///< their values are the defaults
  Interface interface;               ///< its topics and services
  std::shared_ptr<void> defaults{};  ///< the struct that `parameters` points into
};

/// One entry of the registry.
struct Component {
  std::shared_ptr<void> (*make)(Node& node);  ///< constructs it
  ComponentDescription (*describe)();         ///< its description, without running it
};

/// Called by TANDEM_COMPONENT.
TANDEM_EXPORT bool register_component(const char* name, const Component& component);

/// The component of class C, as TANDEM_COMPONENT registers it.
template <class C>
[[nodiscard]] Component component_of() {
  static_assert(
      requires {
        { C::interface() } -> std::convertible_to<Interface>;
      },
      "a component needs `static tandem::rt::Interface interface()`: the topics that it opens");
  return {[](Node& node) -> std::shared_ptr<void> { return std::make_shared<C>(node); },
          [] {
            ComponentDescription description;
            description.interface = C::interface();
            if constexpr (requires { typename C::Params; }) {
              const auto params = std::make_shared<typename C::Params>();
              description.parameters = fields_of(*params);
              description.defaults = params;
            }
            return description;
          }};
}

#ifndef TANDEM_PACKAGE
/// The package of a module's component. tandem_add_component() defines it.
#define TANDEM_PACKAGE ""
#endif

/// Use once, in one .cpp of libtandem_<name>.so:
/// `TANDEM_COMPONENT(tandem::SafetyFilterNode, "safety_filter")`.
///
/// The class has a constructor from `rt::Node&`, a static function `interface()` that returns its
/// topics and services, and, if it declares parameters, their struct as `Params`.
#define TANDEM_COMPONENT(Type, component_name)                                                     \
  namespace {                                                                                      \
  [[gnu::used, gnu::section(".note.tandem"),                                                       \
    gnu::aligned(4)]] constexpr ::tandem::runtime::ModuleMark tandem_module_mark{                  \
      .component = component_name, .package = TANDEM_PACKAGE};                                     \
  [[maybe_unused]] const bool tandem_component_registered = ::tandem::runtime::register_component( \
      component_name, ::tandem::runtime::component_of<Type>());                                    \
  }

/// Folders searched for libtandem_<name>.so, in this order: those of TANDEM_COMPONENT_PATH, the
/// program's, that of libtandem_runtime.so, tandem/ in the latter and, where that is in /usr/lib,
/// /usr/local/lib/tandem. Absolute, and found once: what becomes of the environment or the current
/// folder later has no effect.
[[nodiscard]] TANDEM_EXPORT const std::vector<std::string>& component_folders();
/// Names of the components that can be loaded: registered ones, and those of modules that were
/// built for this Tandem.
[[nodiscard]] TANDEM_EXPORT std::vector<std::string> list_components();

/// The package (CMake project) that the component's module belongs to, read from its file without
/// running its code. Throws std::invalid_argument for an invalid name, an unknown component
/// (listing those found in each folder) and a module without a mark or of another version.
[[nodiscard]] TANDEM_EXPORT std::string package_of(const std::string& component);

/// Loads the component's module, once per process, and returns what it registered. Throws as
/// package_of() does, before any code of the module runs, and std::invalid_argument for a module
/// that cannot be loaded.
[[nodiscard]] TANDEM_EXPORT ComponentDescription description_of(const std::string& component);

/// Checks the parameters that a component would get, without running it. Throws
/// std::invalid_argument with one line (origin, key, bound) for a value that is out of bounds or of
/// another type and for a key that the component does not have, and as description_of() does.
TANDEM_EXPORT void check_parameters(const std::string& component, const NodeOptions& options);

/// Whether the runtime gives every node a parameter of that name (use_sim_time,
/// start_type_description_service, service_configure_introspection, qos_overrides.…).
[[nodiscard]] TANDEM_EXPORT bool is_parameter_of_every_node(const std::string& name);

/// A component, its node and the thread that spins it. Destruction stops it.
class TANDEM_EXPORT RunningComponent {
 public:
  /// Loads and constructs; spins only after start(). Throws as description_of() does, whatever the
  /// component's constructor throws, and std::logic_error if it declared a parameter that its
  /// description lacks.
  RunningComponent(const std::string& component, NodeOptions options);
  ~RunningComponent();
  RunningComponent(RunningComponent&&) noexcept;
  RunningComponent& operator=(RunningComponent&&) noexcept;

  /// Begins to spin the node on a thread of its own. A node on a LocalBus is run by the bus, from
  /// its construction on.
  void start();
  void stop();  ///< returns at once
  void join();  ///< waits until it has stopped
  /// The component's node. While it runs, call only what Node allows to other threads.
  [[nodiscard]] Node& node() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Constructs and starts a component.
[[nodiscard]] TANDEM_EXPORT RunningComponent load_component(const std::string& component,
                                                            NodeOptions options);

}  // namespace tandem::runtime
