// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/user_study/user_study.hpp"

#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTrials = 100;
constexpr int kMaxTests = 10'000;  // maximum number of files in a folder
constexpr double kHour = 3600.0;   // [s] maximum duration of a trial

double bounded(const json& from, const char* name, double most) {
  const double value = from.at(name).get<double>();
  if (!(value >= 0.0 && value <= most))
    throw std::invalid_argument(std::string{name} + " is outside [0, " + std::to_string(most) +
                                "]");
  return value;
}

std::string method_of(const json& from) {
  auto method = from.at("method").get<std::string>();
  for (const char* known : {"manual", "shared", "blend", "adaptive", "autonomous"})
    if (method == known) return method;
  throw std::invalid_argument("method is not one of manual, shared, blend, adaptive, autonomous");
}

UserTrial trial_from(const json& from) {
  constexpr double kFar = 1e5;
  UserTrial trial = parse_trial_asked(from);
  trial.time = bounded(from, "time", kHour);
  trial.reached = from.at("reached").get<bool>();
  trial.collisions = static_cast<int>(bounded(from, "collisions", kFar));
  trial.min_clearance = bounded(from, "min_clearance", kFar);
  trial.path_length = bounded(from, "path_length", kFar);
  return trial;
}

void write(const std::filesystem::path& path, const std::string& text, std::ios::openmode mode) {
  std::ofstream file{path, mode};
  file << text;
  if (!file.flush()) throw std::runtime_error(path.string() + " is not writable");
}

}  // namespace

void to_json(json& to, const UserTrial& trial) {
  to = {{"method", trial.method},
        {"task", trial.task},
        {"practice", trial.practice},
        {"allowed", trial.allowed},
        {"time", trial.time},
        {"reached", trial.reached},
        {"collisions", trial.collisions},
        {"min_clearance", trial.min_clearance},
        {"path_length", trial.path_length}};
}

UserTrial parse_trial_asked(const json& from) {
  return {.method = method_of(from),
          .task = static_cast<int>(bounded(from, "task", 2.0)),
          .practice = from.at("practice").get<bool>(),
          .allowed = bounded(from, "allowed", kHour)};
}

UserStudy parse_user_study(std::string_view text) {
  try {
    const json from = parse_json(text);
    UserStudy test{static_cast<int>(bounded(from, "person", 1e6)), {}};
    for (const auto& trial : from.at("trials")) test.trials.push_back(trial_from(trial));
    if (test.trials.empty() || test.trials.size() > kMaxTrials)
      throw std::invalid_argument("trials: one to " + std::to_string(kMaxTrials));
    return test;
  } catch (const json::exception& error) {
    throw std::invalid_argument(error.what());
  }
}

std::string to_csv(const UserStudy& test, bool heading) {
  std::string csv =
      heading ? "person,method,task,practice,allowed,time,reached,collisions,min_clearance,"
                "path_length\n"
              : "";
  for (const auto& t : test.trials) {
    csv += std::to_string(test.person) + "," + t.method + "," + std::to_string(t.task) + "," +
           std::to_string(int{t.practice}) + "," + json(t.allowed).dump() + "," +
           json(t.time).dump() + "," + std::to_string(int{t.reached}) + "," +
           std::to_string(t.collisions) + "," + json(t.min_clearance).dump() + "," +
           json(t.path_length).dump() + "\n";
  }
  return csv;
}

std::filesystem::path save(const UserStudy& test, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": " + error.message());
  for (int k = 1; k <= kMaxTests; ++k) {
    const auto path = folder / ("user_test_" + std::to_string(k) + ".json");
    if (std::filesystem::exists(path)) continue;
    const auto csv = folder / "user_tests.csv";
    write(csv, to_csv(test, !std::filesystem::exists(csv)), std::ios::app);
    const json whole{{"person", test.person}, {"trials", test.trials}};
    write(path, whole.dump(2) + "\n", std::ios::out);
    return path;
  }
  throw std::runtime_error(folder.string() + " holds " + std::to_string(kMaxTests) + " tests");
}

}  // namespace tandem
