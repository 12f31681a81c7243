// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/driver.hpp"

#include <algorithm>
#include <stdexcept>

namespace tandem {
namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const std::vector<std::string>& all_drivers() {
  static const std::vector<std::string> all{"navigator", "pointer",   "script",
                                            "reckless",  "adversary", "replay"};
  return all;
}

DriverName::DriverName(const std::string& text) {
  std::size_t begin = 0;
  for (bool first = true; begin <= text.size(); first = false) {
    const std::size_t end = std::min(text.find('+', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    if (!holds(first ? all_drivers() : all_modifiers(), part))
      throw std::invalid_argument("driver `" + text + "`: `" + part + "` is not one of " +
                                  joined(first ? all_drivers() : all_modifiers()) +
                                  (first ? "; modifiers are appended with +" : ""));
    if (first)
      driver = part;
    else
      modifiers.insert(part);
    begin = end + 1;
  }
}

Driver::Person Driver::person(const DriverParams& params, const std::string& name, unsigned seed) {
  if (name == "pointer") return Pointer{params.navigator, seed};
  if (name == "script")
    return Script{params.script, params.navigator, footprint_of(params.robot), seed};
  if (name == "reckless") return Reckless{params.reckless_time, seed};
  if (name == "adversary") return Adversary{seed};
  if (name == "replay")
    return Replay{{params.replay_t, params.replay_linear, params.replay_angular}};
  return Navigator{params.navigator, seed};
}

// The hand has its own random numbers, so that modifiers do not change the driver's intention.
Driver::Driver(const DriverParams& params, unsigned seed)
    : name_{params.driver},
      person_{person(params, name_.driver, seed)},
      hand_{params.hand, name_.modifiers, params.navigator.rate, seed + 0x5eed} {
  check(params);
}

Hand Driver::mean(const Pose2& X_MB, const Pose2& X_MS, double t) {
  if (auto* navigator = std::get_if<Navigator>(&person_)) return navigator->steer(X_MB, X_MS, t);
  if (auto* pointer = std::get_if<Pointer>(&person_)) return pointer->steer(X_MB, X_MS, t);
  if (auto* script = std::get_if<Script>(&person_)) return script->steer(X_MB, X_MS, t);
  if (auto* reckless = std::get_if<Reckless>(&person_)) return reckless->steer(X_MS, t);
  if (auto* adversary = std::get_if<Adversary>(&person_))
    return adversary->steer(X_MB, X_MS, map_.get(), t);
  return std::get<Replay>(person_).steer(t);
}

Hand Driver::steer(const Pose2& X_MB, const Pose2& X_MS, double t) {
  Hand meant = mean(X_MB, X_MS, t);
  if (arrived()) meant.holds = false;
  return hand_.apply(meant, t);
}

bool Driver::arrived() const {
  if (const auto* navigator = std::get_if<Navigator>(&person_)) return navigator->arrived();
  if (const auto* pointer = std::get_if<Pointer>(&person_)) return pointer->arrived();
  if (const auto* script = std::get_if<Script>(&person_)) return script->arrived();
  if (const auto* reckless = std::get_if<Reckless>(&person_)) return reckless->arrived();
  if (const auto* replay = std::get_if<Replay>(&person_)) return replay->arrived();
  return false;
}

}  // namespace tandem
