// SPDX-License-Identifier: Apache-2.0
// Reads a study file: its drives, and the description that distinguishes it from other studies.
#include "bringup/study/study.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/drive/parallel_drives.hpp"
#include "bringup/scenario/checksum.hpp"
#include "bringup/scenario/method.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "tandem/config/yaml_document.hpp"
#include "tandem/config/yaml_reader.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const char* const kKeys = "scenarios, robots, methods, drivers, seeds, overrides";

using Parameters = std::map<std::string, std::map<std::string, rt::ParameterValue>>;

struct StudyMethod {
  std::string name, method;
  bool enforce = true;
  Parameters parameters;
};

struct Person {
  std::string name{}, driver{}, recording{}, recording_topic{};
  std::map<std::string, rt::ParameterValue> parameters{};
};

std::string beside(const std::string& file, const std::string& relative) {
  const fs::path path{relative};
  if (path.is_absolute()) return relative;
  return (fs::path(file).parent_path() / path).lexically_normal().string();
}

// Whether the driver is `replay`, with or without modifiers.
bool is_replay(const std::string& driver) {
  return driver == "replay" || driver.starts_with("replay+");
}

void merge(Parameters& into, const Parameters& values) {
  for (const auto& [component, entries] : values)
    for (const auto& [key, value] : entries) into[component][key] = value;
}

class StudyReader {
 public:
  explicit StudyReader(const std::string& path) : path_{path}, yaml_{path}, root_{yaml_.load()} {
    yaml_.allow(root_, {"study", "about", "scenarios", "robots", "methods", "drivers", "seeds",
                        "overrides", "parts"});
  }

  Study read() {
    study_.path = path_;
    study_.name = name(yaml_.required(root_, "study"), "study");
    if (const YAML::Node parts = root_["parts"]) {
      if (!parts.IsSequence() || parts.size() == 0)
        yaml_.fail(parts, "`parts` needs a list of maps with any of " + std::string(kKeys));
      for (const auto& part : parts) read_part(part);
    } else {
      read_part(YAML::Node{YAML::NodeType::Map});
    }
    describe();
    return std::move(study_);
  }

 private:
  std::string word(const YAML::Node& node, const char* key) const {
    if (!node.IsScalar() || node.Scalar().empty())
      yaml_.fail(node, fmt::format("`{}` needs a word", key));
    return node.Scalar();
  }

  // A word that can be part of a file name.
  std::string name(const YAML::Node& node, const char* key) const {
    if (word(node, key).find('/') != std::string::npos)
      yaml_.fail(node, fmt::format("`{}` = {}: a name may not hold a `/`", key, node.Scalar()));
    return node.Scalar();
  }

  // The part's value of a key, or the study's if the part has none.
  YAML::Node said(const YAML::Node& part, const char* key) const {
    const YAML::Node own = part[key];
    return own ? own : root_[key];
  }

  void read_part(const YAML::Node& part) {
    yaml_.allow(part, {"scenarios", "robots", "methods", "drivers", "seeds", "overrides"});
    const auto scenarios = with_robots(read_scenarios(part), said(part, "robots"));
    const auto people = read_people(said(part, "drivers"));
    const auto seeds = read_seeds(part);
    for (const Scenario& scenario : scenarios)
      for (const StudyMethod& method : read_methods(said(part, "methods"), scenario))
        for (const Person& person : people) add_cell(scenario, method, person, seeds);
  }

  std::vector<Scenario> read_scenarios(const YAML::Node& part) {
    const YAML::Node list = said(part, "scenarios");
    if (!list || !list.IsSequence() || list.size() == 0)
      yaml_.fail(list              ? list
                 : part.size() > 0 ? part
                                   : root_,
                 "`scenarios` needs a list of scenario files, relative to this file");
    Parameters overrides;
    if (const YAML::Node node = said(part, "overrides"))
      overrides = component_parameters(node, path_);
    std::vector<Scenario> scenarios;
    for (const auto& node : list) {
      scenarios.push_back(read_scenario(node));
      merge(scenarios.back().parameters, overrides);
    }
    return scenarios;
  }

  // Combines each scenario with each robot. A robot other than the scenario's own is added to the
  // name.
  std::vector<Scenario> with_robots(const std::vector<Scenario>& scenarios,
                                    const YAML::Node& list) const {
    if (!list) return scenarios;
    if (!list.IsSequence() || list.size() == 0)
      yaml_.fail(list, "`robots` needs a list of robots' files, relative to this file");
    std::vector<Scenario> all;
    for (const Scenario& scenario : scenarios)
      for (const auto& node : list) all.push_back(with_robot(scenario, node));
    return all;
  }

  Scenario with_robot(Scenario scenario, const YAML::Node& node) const {
    const std::string file = beside(path_, word(node, "robots"));
    if (!fs::is_regular_file(file))
      yaml_.fail(node, "no robot file " + file + "; it is looked for relative to this file");
    if (fs::weakly_canonical(file) == fs::weakly_canonical(scenario.robot)) return scenario;
    scenario.robot = file;
    scenario.name += "_" + fs::path{file}.stem().string();
    return scenario;
  }

  Scenario read_scenario(const YAML::Node& node) {
    if (node.IsMap()) yaml_.allow(node, {"file", "name", "map", "duration"});
    const YAML::Node file = node.IsMap() ? yaml_.required(node, "file") : node;
    const std::string path = beside(path_, word(file, "scenarios"));
    if (!fs::is_regular_file(path))
      yaml_.fail(file, "no scenario file " + path + "; it is looked for relative to this file");
    Scenario scenario = load_scenario(path);
    files_.insert(path);
    if (!node.IsMap()) return scenario;
    if (const auto given = node["name"]) scenario.name = name(given, "name");
    if (const auto map = node["map"]) {
      scenario.map = word(map, "map");
      if (scenario.map != "clutter") scenario.map = beside(path_, scenario.map);
    }
    if (const auto duration = node["duration"])
      scenario.duration = yaml_.number(duration, 0.1, 1e6);
    return scenario;
  }

  std::vector<StudyMethod> read_methods(const YAML::Node& list, const Scenario& scenario) const {
    std::vector<StudyMethod> methods;
    if (!list || (list.IsScalar() && list.Scalar() == "all")) {
      for (const auto& name : scenario.methods) methods.push_back({name, name, true, {}});
      return methods;
    }
    if (!list.IsSequence() || list.size() == 0)
      yaml_.fail(list, "`methods` needs a list of methods, or `all`: those the scenario lists");
    for (const auto& node : list) methods.push_back(read_method(node));
    return methods;
  }

  StudyMethod read_method(const YAML::Node& node) const {
    StudyMethod method;
    if (node.IsMap()) {
      yaml_.allow(node, {"name", "method", "enforce", "parameters"});
      method.method = word(yaml_.required(node, "method"), "method");
      method.enforce = yaml_.flag(node, "enforce", true);
      if (const auto parameters = node["parameters"])
        method.parameters = component_parameters(parameters, path_);
      method.name = name(yaml_.required(node, "name"), "name");
    } else {
      method.name = method.method = word(node, "methods");
    }
    try {
      (void)drive_method(method.method);
    } catch (const std::invalid_argument& error) {
      yaml_.fail(node, error.what());
    }
    return method;
  }

  std::vector<Person> read_people(const YAML::Node& list) const {
    if (!list) return {{}};
    if (!list.IsSequence() || list.size() == 0)
      yaml_.fail(list, "`drivers` needs a list of drivers");
    std::vector<Person> people;
    for (const auto& node : list) people.push_back(read_person(node));
    return people;
  }

  Person read_person(const YAML::Node& node) const {
    if (!node.IsMap()) return {.name = word(node, "drivers"), .driver = word(node, "drivers")};
    Person person;
    yaml_.each_once(node);
    for (const auto& entry : node) {
      const std::string key = entry.first.Scalar();
      if (key == "name")
        person.name = name(entry.second, "name");
      else if (key == "driver")
        person.driver = word(entry.second, "driver");
      else if (key == "recording")
        person.recording = beside(path_, word(entry.second, "recording"));
      else if (key == "recording_topic")
        person.recording_topic = word(entry.second, "recording_topic");
      else
        person.parameters[key] = {yaml_text(entry.second),
                                  fmt::format("{}:{}", path_, entry.second.Mark().line + 1)};
    }
    if (person.name.empty()) yaml_.fail(node, "'name' is missing");
    if (!person.recording.empty() && !is_replay(person.driver))
      yaml_.fail(node, "a `recording` needs `driver: replay`");
    return person;
  }

  std::vector<unsigned> read_seeds(const YAML::Node& part) const {
    const YAML::Node node = said(part, "seeds");
    if (!node) yaml_.fail(root_, "`seeds` is missing: 20, 1-20 or [3, 5, 8]");
    std::vector<unsigned> seeds;
    const auto wrong = [&] {
      yaml_.fail(node, "`seeds` = " + yaml_text(node) +
                           ": expected 20, 1-20 or [3, 5, 8], the smallest 1");
    };
    const auto number = [&](const YAML::Node& value) {
      unsigned seed = 0;
      if (!value.IsScalar() || !YAML::convert<unsigned>::decode(value, seed) || seed == 0 ||
          value.Scalar().starts_with('-'))
        wrong();
      return seed;
    };
    if (node.IsSequence()) {
      for (const auto& value : node) seeds.push_back(number(value));
      if (seeds.empty()) wrong();
      return seeds;
    }
    const bool is_range = node.IsScalar() && node.Scalar().find('-') != std::string::npos;
    SeedRange range{1, 1};
    if (!is_range) range.last = number(node);
    try {
      range = seed_range("seeds", is_range ? node.Scalar() : fmt::format("1-{}", range.last));
    } catch (const std::invalid_argument& error) {
      yaml_.fail(node, error.what());
    }
    for (unsigned seed = range.first; seed <= range.last; ++seed) seeds.push_back(seed);
    return seeds;
  }

  void add_cell(Scenario scenario, const StudyMethod& method, const Person& person,
                const std::vector<unsigned>& seeds) {
    merge(scenario.parameters, method.parameters);
    merge(scenario.parameters, {{"driver", person.parameters}});
    DriveOptions options;
    options.method = method.method;
    options.driver = person.driver;
    options.recording = person.recording;
    options.recording_topic = person.recording_topic;
    options.enforce = method.enforce;
    options.lockstep = true;
    scenario.method = method.method;
    if (!person.driver.empty()) scenario.driver = person.driver;
    if (is_replay(scenario.driver) && person.recording.empty() && scenario.recording.empty())
      throw std::invalid_argument(path_ + ": driver `replay` needs a `recording` beside it, as " +
                                  "{name: me, driver: replay, recording: FOLDER}");
    const std::string driver = person.name.empty() ? driver_of(scenario) : person.name;
    study_.cells.push_back({std::move(scenario), options, method.name, driver});
    for (const unsigned seed : seeds) {
      study_.drives.push_back({study_.cells.size() - 1, seed});
      const std::string name = name_of(study_, study_.drives.back());
      if (!names_.insert(name).second)
        throw std::invalid_argument(path_ + ": the drive " + name +
                                    " is listed twice; give one of them another `name`");
    }
  }

  // Uses checksums and paths relative to the study file, because the same study may be in another
  // folder on another machine.
  void describe() {
    auto& description = study_.description;
    description["study"] = study_.name;
    description["study file"] = yaml_text(root_);
    for (const auto& cell : study_.cells) {
      const Scenario& scenario = cell.scenario;
      files_.insert(scenario.robot);
      if (!scenario.fixtures.empty()) files_.insert(scenario.fixtures);
      if (scenario.map != "clutter") files_.insert(scenario.map);
      const auto& played = cell.options.recording;
      for (const auto& file : files_of(played.empty() ? scenario.recording : played))
        files_.insert(file);
    }
    for (const auto& file : files_) description[seen_from_here(file)] = checksum_of(file);
  }

  // A relative path, because base names are not unique.
  [[nodiscard]] std::string seen_from_here(const std::string& file) const {
    const fs::path here = fs::absolute(path_).lexically_normal().parent_path();
    return fs::absolute(file).lexically_normal().lexically_relative(here).generic_string();
  }

  // The files of a recording's folder that hold messages, or the file itself.
  static std::vector<std::string> files_of(const std::string& recording) {
    if (recording.empty()) return {};
    if (!fs::is_directory(recording)) return {recording};
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator{recording})
      if (entry.path().extension() == ".db3") files.push_back(entry.path().string());
    return files;
  }

  static std::uint64_t checksum_of(const std::string& file) {
    std::ifstream in{file, std::ios::binary};
    std::uint64_t sum = checksum({});
    char part[65536];
    while (in.read(part, sizeof part), in.gcount() > 0)
      sum = checksum({part, static_cast<std::size_t>(in.gcount())}, sum);
    return sum;
  }

  std::string path_;
  YamlReader yaml_;
  YAML::Node root_;
  Study study_;
  std::set<std::string> names_, files_;
};

}  // namespace

Study load_study(const std::string& path) { return StudyReader{path}.read(); }

}  // namespace tandem
