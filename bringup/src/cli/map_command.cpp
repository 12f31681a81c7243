// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/map_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "bringup/drive/map_picture.hpp"
#include "tandem/map/barn_world.hpp"
#include "tandem/map/clutter_world.hpp"
#include "tandem/map/map_description.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/obstacle_extractor/extractor.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

struct MapOptions {
  std::string input, output;
  SliceParams slice;
  ClutterParams clutter;
  unsigned seed = 1;
  bool shapes = false;
  bool unknown_is_obstacle = false;
  int size = 1400;
  double wall_height = kWallHeight;
};

// Adds an option for each field of a parameter struct, named as in YAML with dashes for
// underscores.
struct OptionAdder {
  CLI::App& command;

  template <class Number>
  void operator()(const char* name, Number& value, const Range& range, const char* meaning) const {
    std::string option = std::string("--") + name;
    std::replace(option.begin(), option.end(), '_', '-');
    command.add_option(option, value, meaning)
        ->check(CLI::Range(range.min, range.max))
        ->capture_default_str();
  }
};

// Splits `worlds.json#17`, world 17 of a BARN file, into file and number.
struct WorldName {
  fs::path file;
  std::optional<int> number;

  explicit WorldName(const std::string& input) : file{input} {
    const auto hash = input.rfind('#');
    if (hash == std::string::npos || fs::exists(input)) return;
    const std::string digits = input.substr(hash + 1);
    if (digits.empty() || digits.size() > 6 ||
        digits.find_first_not_of("0123456789") != std::string::npos)
      throw std::runtime_error(input + ": expected the number of a world after #");
    file = input.substr(0, hash);
    number = std::stoi(digits);
  }
};

fs::path output_beside(const MapOptions& options, const char* extension) {
  if (!options.output.empty()) return options.output;
  const WorldName world(options.input);
  fs::path beside = world.file;
  if (world.number) beside.replace_extension().concat("_" + std::to_string(*world.number) + ".x");
  return beside.replace_extension(extension);
}

// Loads a map file of any supported kind, or a world of a BARN file.
std::unique_ptr<octomap::OcTree> load_any(const std::string& input,
                                          double wall_height = kWallHeight) {
  const WorldName world(input);
  return world.number ? build_octomap(load_barn_world(world.file, *world.number))
                      : load_map(input, wall_height);
}

void save(const octomap::OcTree& tree, const fs::path& output) {
  save_octomap(tree, output);
  std::printf("%s: %zu nodes, %ju bytes\n", output.c_str(), tree.size(),
              static_cast<std::uintmax_t>(fs::file_size(output)));
}

// Compares files rather than paths, because the output may be a link to the input.
void keep_input(const std::string& input, const fs::path& output) {
  std::error_code error;  // ignored: the output need not exist yet
  if (fs::equivalent(WorldName(input).file, output, error))
    throw std::runtime_error(input + ": would be overwritten; name another file with -o");
}

void build(const MapOptions& options) {
  const fs::path output = output_beside(options, ".bt");
  keep_input(options.input, output);
  const bool is_description = !is_yaml(options.input) && !WorldName(options.input).number;
  save(is_description ? *build_octomap(load_map_description(options.input))
                      : *load_any(options.input, options.wall_height),
       output);
}

void make_clutter(const MapOptions& options) {
  const fs::path output =
      options.output.empty() ? "clutter_" + std::to_string(options.seed) + ".bt" : options.output;
  save(*build_octomap(clutter_world(options.seed, options.clutter)), output);
  std::printf("start %g %g, goal %g %g\n", kClutterStart.x(), kClutterStart.y(), kClutterGoal.x(),
              kClutterGoal.y());
}

void print_info(const MapOptions& options) {
  const auto tree = load_any(options.input);
  std::array<double, 3> low{}, high{};
  tree->getMetricMin(low[0], low[1], low[2]);
  tree->getMetricMax(high[0], high[1], high[2]);
  const Grid grid = slice(*tree, options.slice);
  const auto count = [&](Cell cell) {
    return std::count(grid.cells.begin(), grid.cells.end(), cell);
  };
  std::printf("file        %s\n", options.input.c_str());
  std::printf("resolution  %g m\n", tree->getResolution());
  std::printf("nodes       %zu (%zu leaves)\n", tree->size(), tree->getNumLeafNodes());
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::printf("%c           %g to %g m\n", "xyz"[axis], low[axis], high[axis]);
  std::printf("slice       z %g to %g m over the floor at %g m: %d × %d cells\n",
              options.slice.z_min, options.slice.z_max, options.slice.floor, grid.width,
              grid.height);
  std::printf("            %td occupied, %td free, %td unknown\n", count(Cell::kOccupied),
              count(Cell::kFree), count(Cell::kUnknown));
}

std::vector<Obstacle> all_shapes(const Grid& grid, bool unknown_is_obstacle) {
  const auto map = std::make_shared<StaticMap>(grid, unknown_is_obstacle);
  const Eigen::Vector2d size{grid.resolution * grid.width, grid.resolution * grid.height};
  ExtractorParams params;
  params.range = 50.0;
  Extractor extractor(map, params);
  std::vector<Obstacle> shapes;
  for (double y = 0.0; y <= size.y(); y += params.range)  // so that the ranges cover the map
    for (double x = 0.0; x <= size.x(); x += params.range)
      for (const Obstacle& shape : extractor.near(grid.origin + Eigen::Vector2d{x, y}))
        shapes.push_back(shape);
  const auto by_id = [](const Obstacle& a, const Obstacle& b) { return a.id < b.id; };
  const auto same = [](const Obstacle& a, const Obstacle& b) { return a.id == b.id; };
  std::sort(shapes.begin(), shapes.end(), by_id);
  shapes.erase(std::unique(shapes.begin(), shapes.end(), same), shapes.end());
  return shapes;
}

void render(const MapOptions& options) {
  const Grid grid = slice(*load_any(options.input), options.slice);
  MapPicture picture(grid, std::nullopt, options.size);
  char title[200];
  std::snprintf(title, sizeof title, "%s   z %g to %g m",
                fs::path(options.input).filename().c_str(), options.slice.z_min,
                options.slice.z_max);
  picture.set_title(title);
  if (options.shapes) {
    const auto shapes = all_shapes(grid, options.unknown_is_obstacle);
    picture.draw_obstacles(shapes, {.color = colors::kShape,
                                    .width = 2.0,
                                    .label = std::to_string(shapes.size()) + " fitted shapes"});
  }
  const fs::path output = output_beside(options, ".png");
  keep_input(options.input, output);
  picture.write_png(output);
  std::printf("%s\n", output.c_str());
}

}  // namespace

void add_map_command(CLI::App& program) {
  CLI::App* const map = program.add_subcommand("map", "Build, describe and draw maps");
  map->require_subcommand(1);
  const auto options = std::make_shared<MapOptions>();
  const auto add = [&](const char* name, const char* what, void (*run)(const MapOptions&)) {
    CLI::App* const command = map->add_subcommand(name, what);
    command->callback([options, run] { run(*options); });
    return command;
  };

  CLI::App* const build_it =
      add("build", "Make an OctoMap (.bt) from a map description or a Nav2 map", build);
  build_it
      ->add_option("description", options->input,
                   "map description or map of Nav2's map_server (.yaml), or a BARN world: "
                   "worlds.json#17")
      ->required();
  build_it->add_option("-o,--output", options->output,
                       "output file; default: the input's path, ending in .bt");

  build_it
      ->add_option("--height", options->wall_height, "[m] height of the walls made from a Nav2 map")
      ->check(CLI::Range(1e-3, 100.0))
      ->capture_default_str();

  CLI::App* const clutter = add("clutter", "Make a random, passable clutter world", make_clutter);
  clutter->add_option("--seed", options->seed, "seed of the world")->capture_default_str();
  clutter->add_option("-o,--output", options->output, "output file; default: clutter_SEED.bt");
  options->clutter.visit(OptionAdder{*clutter});

  CLI::App* const info =
      add("info", "Print extent, resolution and cell counts of a map", print_info);
  info->add_option("map", options->input,
                   "OctoMap (.bt, .ot), Nav2 map or map description (.yaml), or worlds.json#17")
      ->required();
  options->slice.visit(OptionAdder{*info});

  CLI::App* const draw = add("render", "Draw a map as a PNG", render);
  draw->add_option("map", options->input,
                   "OctoMap (.bt, .ot), Nav2 map or map description (.yaml), or worlds.json#17")
      ->required();
  draw->add_option("-o,--output", options->output,
                   "output file; default: the input's path, ending in .png");
  draw->add_option("--size", options->size, "[pixels] length of the longer side")
      ->check(CLI::Range(200, 8000))
      ->capture_default_str();
  draw->add_flag("--shapes", options->shapes, "draw the shapes fitted to it");
  draw->add_flag("--unknown-is-obstacle", options->unknown_is_obstacle,
                 "fit shapes to unknown cells too");
  options->slice.visit(OptionAdder{*draw});
}

}  // namespace tandem
