// SPDX-License-Identifier: Apache-2.0
#include "dashboard/user_test.hpp"

#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace tandem {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTrials = 100;
constexpr int kMaxTests = 10'000;  // files of one folder

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
  throw std::invalid_argument("method is none of manual, shared, blend, adaptive, autonomous");
}

UserTrial trial_from(const json& from) {
  constexpr double kHour = 3600.0, kFar = 1e5;
  const auto task = static_cast<int>(bounded(from, "task", 2.0));
  return {.method = method_of(from),
          .task = task,
          .practice = from.at("practice").get<bool>(),
          .allowed = bounded(from, "allowed", kHour),
          .time = bounded(from, "time", kHour),
          .reached = from.at("reached").get<bool>(),
          .collisions = static_cast<int>(bounded(from, "collisions", kFar)),
          .min_clearance = bounded(from, "min_clearance", kFar),
          .path_length = bounded(from, "path_length", kFar)};
}

json to_json(const UserTest& test) {
  json trials = json::array();
  for (const auto& t : test.trials)
    trials.push_back({{"method", t.method},
                      {"task", t.task},
                      {"practice", t.practice},
                      {"allowed", t.allowed},
                      {"time", t.time},
                      {"reached", t.reached},
                      {"collisions", t.collisions},
                      {"min_clearance", t.min_clearance},
                      {"path_length", t.path_length}});
  return {{"person", test.person}, {"trials", std::move(trials)}};
}

void write(const std::filesystem::path& path, const std::string& text, std::ios::openmode mode) {
  std::ofstream file{path, mode};
  file << text;
  if (!file.flush()) throw std::runtime_error(path.string() + " cannot be written");
}

}  // namespace

UserTest parse_user_test(std::string_view text) {
  try {
    const json from = json::parse(text);
    UserTest test{static_cast<int>(bounded(from, "person", 1e6)), {}};
    for (const auto& trial : from.at("trials")) test.trials.push_back(trial_from(trial));
    if (test.trials.empty() || test.trials.size() > kMaxTrials)
      throw std::invalid_argument("trials: one to " + std::to_string(kMaxTrials));
    return test;
  } catch (const json::exception& error) {
    throw std::invalid_argument(error.what());
  }
}

std::string to_csv(const UserTest& test, bool heading) {
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

std::filesystem::path save(const UserTest& test, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": " + error.message());
  for (int k = 1; k <= kMaxTests; ++k) {
    const auto path = folder / ("user_test_" + std::to_string(k) + ".json");
    if (std::filesystem::exists(path)) continue;
    const auto csv = folder / "user_tests.csv";
    write(csv, to_csv(test, !std::filesystem::exists(csv)), std::ios::app);
    write(path, to_json(test).dump(2) + "\n", std::ios::out);
    return path;
  }
  throw std::runtime_error(folder.string() + " holds " + std::to_string(kMaxTests) + " tests");
}

}  // namespace tandem
