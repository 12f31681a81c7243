// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/map_description.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "support/paths.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"

namespace tandem {
namespace {

const std::string kHead = "resolution: 0.05\nbounds: {low: [-1, -1, 0], high: [1, 1, 1]}\n";

StaticMap world(const std::string& text) {
  return StaticMap(slice(*build_octomap(parse_map_description(kHead + text, "test")), {}));
}

std::string complaint(const std::string& text) {
  try {
    (void)parse_map_description(text, "test.yaml");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

bool occupied(const StaticMap& map, double x, double y) {
  const Eigen::Vector2d c = (Eigen::Vector2d{x, y} - map.grid().origin) / map.grid().resolution;
  return map.is_obstacle(static_cast<int>(std::floor(c.x())), static_cast<int>(std::floor(c.y())));
}

TEST(MapDescription, AWallEndsFlatAtItsPointAndFillsItsCorner) {
  const StaticMap map =
      world("walls: [{points: [[-0.5, 0], [0.5, 0], [0.5, 0.5]], thickness: 0.1, height: 1}]");
  EXPECT_TRUE(occupied(map, -0.475, 0.025));
  EXPECT_TRUE(occupied(map, -0.475, -0.025));
  EXPECT_FALSE(occupied(map, -0.525, 0.025));
  EXPECT_FALSE(occupied(map, 0.0, 0.075));
  EXPECT_TRUE(occupied(map, 0.525, -0.025));  // the corner
  EXPECT_TRUE(occupied(map, 0.475, 0.475));
  EXPECT_FALSE(occupied(map, 0.475, 0.525));
}

TEST(MapDescription, ACylinderHasItsArea) {
  const StaticMap map = world("cylinders: [{center: [0.1, 0.2], diameter: 1.0, height: 1}]");
  const double area = 0.05 * 0.05 * static_cast<double>(map.cells_near({0, 0}, 3.0).size());
  EXPECT_NEAR(area, 0.25 * std::numbers::pi, 0.02);
  EXPECT_FALSE(occupied(map, 0.1 + 0.53, 0.2));
  EXPECT_TRUE(occupied(map, 0.1 + 0.46, 0.2));
}

TEST(MapDescription, ABoxTurnsAndHasHeights) {
  const std::string box =
      "boxes: [{center: [0, 0], size: [1, 0.2], angle: 0.7853981634, z: [0.5, 0.7]}]";
  const auto tree = build_octomap(parse_map_description(kHead + box, "test"));
  const auto at = [&](double x, double y, double z) {
    return tree->isNodeOccupied(tree->search(x, y, z));
  };
  EXPECT_TRUE(at(0.3, 0.3, 0.6));
  EXPECT_FALSE(at(0.3, -0.3, 0.6));
  EXPECT_FALSE(at(0.3, 0.3, 0.475));
  EXPECT_FALSE(at(0.3, 0.3, 0.725));
}

TEST(MapDescription, FreeSpaceAndFloorAreFlags) {
  const std::string box = "boxes: [{center: [0, 0], size: [0.2, 0.2], height: 1}]\n";
  const auto count = [&](const std::string& flags, Cell cell, double z) {
    const auto tree = build_octomap(parse_map_description(kHead + box + flags, "test"));
    const Grid grid = slice(*tree, {.z_min = z, .z_max = z + 0.05});
    return std::count(grid.cells.begin(), grid.cells.end(), cell);
  };
  EXPECT_EQ(count("", Cell::kFree, 0.5), 40 * 40 - 16);
  EXPECT_EQ(count("free_space: false", Cell::kFree, 0.5), 0);
  EXPECT_EQ(count("", Cell::kOccupied, -0.05), 0);
  EXPECT_EQ(count("floor: true", Cell::kOccupied, -0.05), 40 * 40);
}

TEST(MapDescription, ErrorsNameTheLine) {
  EXPECT_EQ(complaint("resolution: 0.05\nbounds: {low: [0, 0, 0], high: [1, 1, 1]}\nwals: []\n"),
            "test.yaml:3: unknown key `wals`; valid keys: resolution, bounds, free_space, floor, "
            "walls, boxes, cylinders; did you mean `walls`?");
  EXPECT_TRUE(complaint(kHead + "cylinders:\n- {center: [0, 0], diamter: 1, height: 1}\n")
                  .starts_with("test.yaml:4: `cylinders[0].diameter` is missing; is `diamter` a "
                               "misspelling of it?"));
  EXPECT_TRUE(complaint(kHead + "cylinders:\n- {center: [0, 0], diameter: x, height: 1}\n")
                  .starts_with("test.yaml:4: `cylinders[0].diameter`: expected a number"));
  EXPECT_TRUE(complaint(kHead + "boxes:\n- {center: [0, 0], size: [9, 1], height: 1}\n")
                  .starts_with("test.yaml:4: extends beyond the bounds"));
  EXPECT_TRUE(complaint(kHead + "boxes: []\nboxes: []\n")
                  .starts_with("test.yaml:4: `boxes` is given twice, first in line 3"));
  EXPECT_TRUE(complaint("a: [1\n").starts_with("test.yaml:"));
}

TEST(MapDescription, RefusesDescriptionsThatGiveNoMap) {
  const std::string box = "boxes: [{center: [0, 0], size: [1, 1], height: 1}]\n";
  EXPECT_NE(complaint(""), "");
  EXPECT_NE(complaint("- 1\n"), "");
  EXPECT_NE(complaint(kHead), "");  // nothing solid
  EXPECT_NE(complaint("resolution: .nan\nbounds: {low: [-1, -1, 0], high: [1, 1, 1]}\n" + box), "");
  EXPECT_NE(complaint("resolution: 0.001\nbounds: {low: [-99, -99, 0], high: [99, 99, 9]}\n" + box),
            "");
  EXPECT_NE(complaint(kHead + "boxes: [{center: [0, .inf], size: [1, 1], height: 1}]\n"), "");
  EXPECT_NE(complaint(kHead + "boxes: [{center: [0, 0], size: [1, 0.01], height: 1}]\n"), "");
  EXPECT_NE(complaint(kHead + "boxes: [{center: [0, 0], size: [1, 1], height: 0.01}]\n"), "");
  EXPECT_NE(complaint(kHead + "boxes: [{center: [0, 0], size: [1, 1], height: 1, z: [0, 1]}]\n"),
            "");
  EXPECT_NE(complaint(kHead + "walls: [{points: [[0, 0], [0, 0]], thickness: 0.1, height: 1}]\n"),
            "");
  EXPECT_THROW((void)load_map_description("/nonexistent.yaml"), std::invalid_argument);
}

TEST(MapDescription, TheProjectsMapsAreWhatTheirDescriptionsSay) {
  for (const char* name : {"forest", "corridor", "hall", "home", "slalom", "ward", "yard"}) {
    const auto file = test::source_path("maps/" + std::string{name});
    const auto tree = build_octomap(load_map_description(file + ".yaml"));
    std::ifstream stream(file + ".bt", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_EQ(bytes, bt_file_bytes(*tree)) << name << ": run `tandem map build` again";
  }
}

TEST(MapDescription, TheForestIsTheThesiss) {
  const auto file = test::source_path("maps/forest.bt");
  const StaticMap map(slice(*load_octomap(file), {}));
  const double x[] = {-4, -2, 0.5, 3, -2.5, 0, 2, -4, -1, 3, -2, 1, 4, -1, 1, 3};
  const double y[] = {3.5, 3, 3.5, 4, 1.5, 1.5, 2, 0, 0, 0.5, -2, -1, -1, -4, -3, -3};
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(occupied(map, x[i], y[i])) << i;
  EXPECT_NEAR(map.distance({-4.0, -4.0}), 1.0, 0.08);  // the start, from the walls
  EXPECT_FALSE(occupied(map, 4.0, 2.5));
}

TEST(MapDescription, TheWardDependsOnTheHeightOfTheRobot) {
  const auto file = test::source_path("maps/ward.bt");
  const auto tree = load_octomap(file);
  const StaticMap low(slice(*tree, {.z_min = 0.1, .z_max = 0.25}));
  const StaticMap seat(slice(*tree, {.z_min = 0.1, .z_max = 0.65}));
  const StaticMap tall(slice(*tree, {.z_min = 0.1, .z_max = 1.0}));
  EXPECT_TRUE(occupied(low, 8.7, 3.65));  // a leg of the table
  EXPECT_FALSE(occupied(low, 1.5, 4.6));  // under the bed
  EXPECT_TRUE(occupied(seat, 1.5, 4.6));
  EXPECT_FALSE(occupied(seat, 9.5, 4.0));  // under the table
  EXPECT_TRUE(occupied(tall, 9.5, 4.0));
  EXPECT_FALSE(occupied(seat, 6.0, -1.075));
  EXPECT_TRUE(occupied(tall, 6.0, -1.075));  // the handrail
  for (const Eigen::Vector2d& room : {Eigen::Vector2d{3.0, 3.0}, Eigen::Vector2d{7.5, 3.0}})
    EXPECT_TRUE(tall.can_pass({1.0, 0.0}, room, 0.4));
}

}  // namespace
}  // namespace tandem
