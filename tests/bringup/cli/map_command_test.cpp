// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/map_command.hpp"

#include <cairo.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

#include "bringup/drive/map_picture.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const fs::path kMaps = test::source_path("maps");

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Runs `tandem ARGUMENTS` in a separate folder.
class MapCommand : public ::testing::Test {
 protected:
  MapCommand()
      : folder_{fs::temp_directory_path() / ("tandem_map_test_" + std::to_string(getpid()))} {
    fs::create_directories(folder_);
  }
  ~MapCommand() override { fs::remove_all(folder_); }

  static void run(const std::string& arguments) {
    CLI::App program{"tandem"};
    add_map_command(program);
    program.parse(arguments);
  }
  [[nodiscard]] std::string in_folder(const std::string& name) const {
    return (folder_ / name).string();
  }

  fs::path folder_;
};

// Colour of a pixel as 0xRRGGBB.
std::uint32_t pixel(const fs::path& png, const Eigen::Vector2d& at) {
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> image{
      cairo_image_surface_create_from_png(png.c_str()), cairo_surface_destroy};
  EXPECT_EQ(cairo_surface_status(image.get()), CAIRO_STATUS_SUCCESS);
  const auto* row = cairo_image_surface_get_data(image.get()) +
                    static_cast<int>(at.y()) * cairo_image_surface_get_stride(image.get());
  return reinterpret_cast<const std::uint32_t*>(row)[static_cast<int>(at.x())] & 0xffffffU;
}

TEST_F(MapCommand, BuildsAnOctomapFromADescription) {
  run("map build " + (kMaps / "slalom.yaml").string() + " -o " + in_folder("out.bt"));
  EXPECT_EQ(bytes_of(in_folder("out.bt")), bytes_of(kMaps / "slalom.bt"));
}

TEST_F(MapCommand, BuildsAWorldOfABarnFile) {
  std::ofstream(in_folder("worlds.json"))
      << R"({"meta": {"cylinder_radius_m": 0.075, "start": {"x": 1, "y": 1},
             "goal": {"x": 1, "y": 5}}, "worlds": {"17": {"cylinders": [[0.075, 0.075]]}}})";
  run("map build " + in_folder("worlds.json#17"));
  EXPECT_TRUE(fs::exists(in_folder("worlds_17.bt")));
  testing::internal::CaptureStdout();
  run("map info " + in_folder("worlds.json#17"));
  EXPECT_NE(testing::internal::GetCapturedStdout().find("9 occupied"), std::string::npos);
  EXPECT_THROW(run("map build " + in_folder("worlds.json#18")), std::runtime_error);
  EXPECT_THROW(run("map build " + in_folder("worlds.json#x")), std::runtime_error);
}

// Nav2's map_saver format: a wall of two pixels on free ground.
TEST_F(MapCommand, BuildsAnOctomapOfTheHeightAskedForFromNav2sMap) {
  std::ofstream(in_folder("room.pgm")) << "P2 4 3 255 254 254 254 254 254 0 0 254 254 254 254 254";
  std::ofstream(in_folder("room.yaml"))
      << "image: room.pgm\nmode: trinary\nresolution: 0.5\norigin: [-1, 0, 0]\nnegate: 0\n"
         "occupied_thresh: 0.65\nfree_thresh: 0.25\n";
  run("map build " + in_folder("room.yaml") + " -o " + in_folder("room.bt") + " --height 1.0");
  testing::internal::CaptureStdout();
  run("map info " + in_folder("room.bt"));
  run("map info " + in_folder("room.yaml"));
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("z           0 to 1 m"), std::string::npos) << text;
  EXPECT_NE(text.find("z           0 to 2 m"), std::string::npos) << text;
  const auto first = text.find("4 × 3 cells");
  EXPECT_NE(text.find("2 occupied, 10 free, 0 unknown", first), std::string::npos) << text;
  EXPECT_NE(text.find("4 × 3 cells", first + 1), std::string::npos) << text;
}

TEST_F(MapCommand, MakesClutterFromASeed) {
  run("map clutter --seed 3 -o " + in_folder("a.bt"));
  run("map clutter --seed 3 -o " + in_folder("b.bt"));
  run("map clutter --seed 4 -o " + in_folder("c.bt"));
  EXPECT_EQ(bytes_of(in_folder("a.bt")), bytes_of(in_folder("b.bt")));
  EXPECT_NE(bytes_of(in_folder("a.bt")), bytes_of(in_folder("c.bt")));
}

TEST_F(MapCommand, DrawsAPngOfAMap) {
  for (const char* input : {"slalom.bt", "slalom.yaml"}) {
    run("map render " + (kMaps / input).string() + " --shapes --z-min 0.2 --z-max 0.8 -o " +
        in_folder("out.png"));
    EXPECT_TRUE(bytes_of(in_folder("out.png")).starts_with("\x89PNG"));
  }
}

TEST_F(MapCommand, PrintsTheContentsOfAMap) {
  testing::internal::CaptureStdout();
  run("map info " + (kMaps / "forest.bt").string());
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("resolution  0.05 m"), std::string::npos) << text;
  EXPECT_NE(text.find("204 × 204 cells"), std::string::npos) << text;
}

TEST_F(MapCommand, ErrorsAreOneLine) {
  std::ofstream(in_folder("cut.bt")) << bytes_of(kMaps / "forest.bt").substr(0, 3000);
  for (const std::string& arguments :
       {"map info " + in_folder("none.bt"), "map info " + in_folder("cut.bt"),
        "map build " + in_folder("none.yaml"), "map render " + folder_.string(),
        "map render " + (kMaps / "forest.bt").string() + " -o /nonexistent/x.png",
        "map render " + (kMaps / "forest.bt").string() + " --z-min 2 --z-max 1"})
    try {
      run(arguments);
      ADD_FAILURE() << arguments;
    } catch (const std::exception& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_FALSE(std::string(error.what()).empty());
    }
}

TEST_F(MapCommand, NorOverItsInputUnderAnotherName) {
  fs::copy_file(kMaps / "forest.yaml", folder_ / "a.yaml");
  fs::copy_file(kMaps / "forest.bt", folder_ / "f.bt");
  fs::create_symlink(folder_ / "f.bt", folder_ / "link.bt");
  const std::string folder = folder_.string();
  for (const std::string& command : {"map build " + folder + "/./a.yaml -o " + folder + "/a.yaml",
                                     "map render " + folder + "/f.bt -o " + folder + "/f.bt",
                                     "map render " + folder + "/f.bt -o " + folder + "/link.bt"})
    EXPECT_THROW(run(command), std::runtime_error) << command;
  EXPECT_EQ(bytes_of(folder_ / "f.bt"), bytes_of(kMaps / "forest.bt"));
  EXPECT_EQ(bytes_of(folder_ / "a.yaml"), bytes_of(kMaps / "forest.yaml"));
}

TEST_F(MapCommand, NeverWritesOverItsInput) {
  std::ofstream(in_folder("a.bt")) << bytes_of(kMaps / "slalom.yaml");
  EXPECT_THROW(run("map build " + in_folder("a.bt")), std::runtime_error);
  EXPECT_EQ(bytes_of(in_folder("a.bt")), bytes_of(kMaps / "slalom.yaml"));
}

TEST_F(MapCommand, PictureHasEachThingAtItsPlace) {
  Grid grid{0.5, {-1.0, 2.0}, 4, 2, std::vector<Cell>(8, Cell::kFree)};
  grid.cells[1] = Cell::kOccupied;  // centre (-0.25, 2.25)
  grid.cells[7] = Cell::kUnknown;   // centre (0.75, 2.75)
  MapPicture picture(grid, std::nullopt, 600);
  picture.draw_rectangle({{-1.0, 2.5}, {-0.5, 3.0}},
                         {.color = colors::kGoal, .fill = Color{0.0, 1.0, 0.0}});
  picture.draw_path(std::vector<Eigen::Vector2d>{{0.25, 2.0}, {0.25, 3.0}},
                    {.color = {1.0, 0.0, 0.0}, .width = 6.0});
  picture.write_png(in_folder("out.png"));
  const auto color_at = [&](double x, double y) {
    return pixel(in_folder("out.png"), picture.to_pixel({x, y}));
  };
  EXPECT_LT(color_at(-0.25, 2.25) & 0xffU, 0x60U);  // dark
  EXPECT_EQ(color_at(-0.75, 2.25), 0xffffffU);      // free
  EXPECT_NE(color_at(0.75, 2.75), 0xffffffU);       // unknown
  EXPECT_EQ(color_at(-0.75, 2.75), 0x00ff00U);
  EXPECT_EQ(color_at(0.25, 2.5), 0xff0000U);
}

TEST(MapPicture, RefusesNothing) {
  EXPECT_THROW(MapPicture{Grid{}}, std::invalid_argument);
  const Grid grid{0.5, {0.0, 0.0}, 1, 1, {Cell::kFree}};
  EXPECT_THROW(MapPicture(grid, Area{{0, 0}, {0, 1}}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
