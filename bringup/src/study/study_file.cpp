// SPDX-License-Identifier: Apache-2.0
// Reads a study file: its drives, and the description that distinguishes it from other studies.
#include "bringup/study/study.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/bag/bag_files.hpp"
#include "bringup/drive/parallel_drives.hpp"
#include "bringup/scenario/checksum.hpp"
#include "bringup/scenario/method.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "bringup/system/shared_files.hpp"
#include "tandem/config/yaml_reader.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// What a study may say for all its parts, or a part for itself.
const std::vector<std::string> kPartKeys{"scenarios", "robots", "methods",
                                         "drivers",   "seeds",  "overrides"};

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

// Whether the driver is `replay`, with or without modifiers.
bool is_replay(const std::string& driver) {
  return driver == "replay" || driver.starts_with("replay+");
}

void merge(Parameters& into, const Parameters& values) {
  for (const auto& [component, entries] : values)
    for (const auto& [key, value] : entries) into[component][key] = value;
}

std::string word(const YamlReader& value) {
  const auto text = value.is_scalar() ? value.as<std::string>() : "";
  if (text.empty()) value.fail(value.key() + " needs a word");
  return text;
}

// A word that can be part of a file name.
std::string name(const YamlReader& value) {
  const std::string text = word(value);
  if (text.find('/') != std::string::npos)
    value.fail(fmt::format("{} = {}: a name may not hold a `/`", value.key(), text));
  return text;
}

// The elements of a list that must have some.
std::vector<YamlReader> elements(const YamlReader& list, const std::string& what) {
  if (!list.is_list() || list.elements().empty())
    list.fail(list.key() + " must be a list of " + what);
  return list.elements();
}

StudyMethod read_method(YamlReader& value) {
  StudyMethod method;
  if (value.is_map()) {
    method.method = word(value.required("method"));
    method.name = name(value.required("name"));
    method.enforce = value.optional("enforce", true);
    if (const auto parameters = value.optional("parameters"))
      method.parameters = component_parameters(*parameters);
    value.finish();
  } else {
    method.name = method.method = word(value);
  }
  try {
    (void)drive_method(method.method);
  } catch (const std::invalid_argument& error) {
    value.fail(error.what());
  }
  return method;
}

Person read_person(YamlReader& value) {
  if (!value.is_map()) return {.name = word(value), .driver = word(value)};
  Person person;
  person.name = name(value.required("name"));
  if (const auto driver = value.optional("driver")) person.driver = word(*driver);
  if (const auto played = value.optional("recording")) {
    (void)word(*played);
    person.recording = played->path();
  }
  if (const auto topic = value.optional("recording_topic")) person.recording_topic = word(*topic);
  for (const auto& [key, parameter] : value.rest())
    person.parameters[key] = {parameter.text(), parameter.place()};
  if (!person.recording.empty() && !is_replay(person.driver))
    value.fail("a `recording` needs `driver: replay`");
  return person;
}

std::vector<Person> read_people(const std::optional<YamlReader>& list) {
  if (!list) return {{}};
  std::vector<Person> people;
  for (YamlReader& value : elements(*list, "drivers")) people.push_back(read_person(value));
  return people;
}

[[noreturn]] void refuse_seeds(const YamlReader& value) {
  value.fail(value.key() + " = " + value.text() +
             ": expected 20, 1-20 or [3, 5, 8], the smallest 1");
}

unsigned read_seed(const YamlReader& value, const YamlReader& seeds) {
  const auto text = value.is_scalar() ? value.as<std::string>() : "";
  unsigned seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc{} || end != text.data() + text.size() || seed == 0) refuse_seeds(seeds);
  return seed;
}

SeedRange read_range(const YamlReader& seeds) {
  const auto text = seeds.is_scalar() ? seeds.as<std::string>() : "";
  try {
    return seed_range("seeds", text.find('-') != std::string::npos
                                   ? text
                                   : fmt::format("1-{}", read_seed(seeds, seeds)));
  } catch (const std::invalid_argument& error) {
    seeds.fail(error.what());
  }
}

std::vector<unsigned> read_seeds(const YamlReader& value) {
  std::vector<unsigned> seeds;
  if (value.is_list()) {
    for (const YamlReader& seed : value.elements()) seeds.push_back(read_seed(seed, value));
    if (seeds.empty()) refuse_seeds(value);
    return seeds;
  }
  const SeedRange range = read_range(value);
  for (unsigned seed = range.first; seed <= range.last; ++seed) seeds.push_back(seed);
  return seeds;
}

class StudyReader {
 public:
  explicit StudyReader(const std::string& path) : path_{path}, root_{YamlReader::load(path)} {}

  Study read() {
    study_.path = path_;
    study_.name = name(root_.required("study"));
    (void)root_.optional("about");
    for (const auto& key : kPartKeys) (void)root_.optional(key);
    const auto parts = root_.optional("parts");
    root_.finish();
    if (parts)
      for (YamlReader& part :
           elements(*parts, fmt::format("maps with any of {}", fmt::join(kPartKeys, ", "))))
        read_part(part);
    else
      read_part(root_);
    describe();
    return std::move(study_);
  }

 private:
  // The part's value of a key, or the study's if the part has none.
  std::optional<YamlReader> value_of(YamlReader& part, const char* key) {
    const auto own = part.optional(key);
    return own ? own : root_.optional(key);
  }

  void read_part(YamlReader& part) {
    for (const auto& key : kPartKeys) (void)part.optional(key);
    part.finish();
    const auto scenarios = with_robots(read_scenarios(part), value_of(part, "robots"));
    const auto people = read_people(value_of(part, "drivers"));
    const auto given = value_of(part, "seeds");
    if (!given) root_.fail("`seeds` is missing: 20, 1-20 or [3, 5, 8]");
    const auto seeds = read_seeds(*given);
    const auto methods = value_of(part, "methods");
    for (const Scenario& scenario : scenarios)
      for (const StudyMethod& method : read_methods(methods, scenario))
        for (const Person& person : people) add_cell(scenario, method, person, seeds);
  }

  std::vector<Scenario> read_scenarios(YamlReader& part) {
    const std::string what = "scenario files, relative to this file";
    const auto list = value_of(part, "scenarios");
    if (!list) part.fail("`scenarios` must be a list of " + what);
    Parameters overrides;
    if (const auto given = value_of(part, "overrides")) overrides = component_parameters(*given);
    std::vector<Scenario> scenarios;
    for (YamlReader& value : elements(*list, what)) {
      scenarios.push_back(read_scenario(value));
      merge(scenarios.back().parameters, overrides);
    }
    return scenarios;
  }

  // Combines each scenario with each robot. A robot other than the scenario's own is added to the
  // name.
  static std::vector<Scenario> with_robots(const std::vector<Scenario>& scenarios,
                                           const std::optional<YamlReader>& list) {
    if (!list) return scenarios;
    std::vector<Scenario> all;
    for (const Scenario& scenario : scenarios)
      for (const YamlReader& value : elements(*list, "robots' files, relative to this file"))
        all.push_back(with_robot(scenario, value));
    return all;
  }

  static Scenario with_robot(Scenario scenario, const YamlReader& value) {
    (void)word(value);
    const std::string file = find_file(value, "robots");
    if (fs::weakly_canonical(file) == fs::weakly_canonical(scenario.robot)) return scenario;
    scenario.robot = file;
    scenario.name += "_" + fs::path{file}.stem().string();
    return scenario;
  }

  // Reads a scenario's file, with changes if the value is a map.
  Scenario read_scenario(YamlReader& value) {
    if (!value.is_map()) return load_file(value);
    Scenario scenario = load_file(value.required("file"));
    if (const auto given = value.optional("name")) scenario.name = name(*given);
    if (const auto map = value.optional("map")) {
      scenario.map = word(*map);
      if (scenario.map != "clutter") scenario.map = find_file(*map, "maps");
    }
    if (const auto duration = value.optional("duration"))
      scenario.duration = duration->number(0.1, 1e6);
    value.finish();
    return scenario;
  }

  Scenario load_file(const YamlReader& value) {
    (void)word(value);
    const std::string path = find_file(value, "scenarios");
    files_.insert(path);
    return load_scenario(path);
  }

  static std::vector<StudyMethod> read_methods(const std::optional<YamlReader>& list,
                                               const Scenario& scenario) {
    std::vector<StudyMethod> methods;
    if (!list || (list->is_scalar() && list->as<std::string>() == "all")) {
      for (const auto& name : scenario.methods) methods.push_back({name, name, true, {}});
      return methods;
    }
    for (YamlReader& value : elements(*list, "methods, or `all`: those the scenario lists"))
      methods.push_back(read_method(value));
    return methods;
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
      throw std::invalid_argument(path_ + ": driver `replay` also needs a `recording`: " +
                                  "{name: me, driver: replay, recording: FOLDER}");
    const std::string driver = person.name.empty() ? driver_of(scenario) : person.name;
    auto& listed = seeds_[fmt::format("{}/{}/{}", scenario.name, method.name, driver)];
    study_.cells.push_back({std::move(scenario), options, method.name, driver});
    for (const unsigned seed : seeds) {
      study_.drives.push_back({study_.cells.size() - 1, seed});
      if (!listed.insert(seed).second)
        throw std::invalid_argument(path_ + ": the drive " + name_of(study_, study_.drives.back()) +
                                    " is listed twice; give one of the two another `name`");
    }
  }

  // Uses checksums and paths relative to the study file, because the same study may be in another
  // folder on another machine.
  void describe() {
    auto& description = study_.description;
    description["study"] = study_.name;
    description["study file"] = root_.text();
    for (const auto& cell : study_.cells) {
      const Scenario& scenario = cell.scenario;
      files_.insert(scenario.robot);
      if (!scenario.fixtures.empty()) files_.insert(scenario.fixtures);
      if (scenario.map != "clutter") files_.insert(scenario.map);
      const auto& played = cell.options.recording;
      const std::string& recording = played.empty() ? scenario.recording : played;
      if (recording.empty()) continue;
      for (const auto& file : bag_files(recording)) files_.insert(file);
    }
    for (const auto& file : files_) description[seen_from_here(file)] = checksum_of(file);
  }

  // A relative path, because base names are not unique.
  [[nodiscard]] std::string seen_from_here(const std::string& file) const {
    const fs::path here = fs::absolute(path_).lexically_normal().parent_path();
    return fs::absolute(file).lexically_normal().lexically_relative(here).generic_string();
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
  YamlReader root_;
  Study study_;
  std::set<std::string> files_;
  std::map<std::string, std::set<unsigned>> seeds_;  // by scenario/method/driver
};

}  // namespace

Study load_study(const std::string& path) { return StudyReader{path}.read(); }

}  // namespace tandem
