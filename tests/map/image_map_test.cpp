// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/image_map.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "support/paths.hpp"
#include "tandem/map/extrude.hpp"
#include "tandem/map/gray_image.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/slice.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// A folder with a Nav2 map.
class ImageMap : public testing::Test {
 protected:
  ImageMap() {
    char name[] = "/tmp/tandem_image_map_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~ImageMap() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream{folder_ / name, std::ios::binary} << bytes;
  }

  // Two columns and three rows from the top: black, grey, white, and a light grey.
  void write_pgm() const {
    write("room.pgm", "P5\n# by hand\n2 3\n255\n" +
                          std::string{'\x00', '\xcd', '\xfe', '\xff', '\x80', '\x00'});
  }

  [[nodiscard]] fs::path write_yaml(const std::string& more, const std::string& image = "room.pgm",
                                    const std::string& origin = "[-1.0, 2.0, 0.0]") const {
    write("room.yaml", "image: " + image + "\nresolution: 0.5\norigin: " + origin +
                           "\noccupied_thresh: 0.65\nfree_thresh: 0.19\n" + more);
    return folder_ / "room.yaml";
  }

  [[nodiscard]] std::vector<int> percents(const std::string& more) const {
    const auto plane = load_image_map(write_yaml(more));
    return {plane.percent.begin(), plane.percent.end()};
  }

  // The error message for the map; empty if it loads.
  [[nodiscard]] static std::string complaint(const fs::path& file) {
    try {
      (void)load_map(file);
      return "";
    } catch (const std::exception& error) {
      EXPECT_EQ(std::string{error.what()}.find('\n'), std::string::npos) << error.what();
      return error.what();
    }
  }

  void write_png(const std::string& name, png_uint_32 format, int width,
                 const std::vector<std::uint8_t>& pixels) const {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height =
        static_cast<png_uint_32>(pixels.size() / PNG_IMAGE_SAMPLE_CHANNELS(format)) / image.width;
    image.format = format;
    ASSERT_NE(
        png_image_write_to_file(&image, (folder_ / name).c_str(), 0, pixels.data(), 0, nullptr), 0);
  }

  fs::path folder_;
};

TEST_F(ImageMap, OfTrinaryModeHasTheLowestRowFirst) {
  write_pgm();
  const OccupancyPlane plane = load_image_map(write_yaml("mode: trinary\nnegate: 0\n"));
  EXPECT_EQ(plane.width, 2);
  EXPECT_EQ(plane.height, 3);
  EXPECT_EQ(plane.resolution, 0.5);
  EXPECT_EQ(plane.X_MO, (Pose2{-1.0, 2.0, 0.0}));
  EXPECT_EQ(plane.percent, (std::vector<std::int8_t>{-1, 100, 0, 0, 100, -1}));
}

TEST_F(ImageMap, NegatedHasWhiteWalls) {
  write_pgm();
  const std::vector<int> negated{-1, 0, 100, 100, 0, 100};
  EXPECT_EQ(percents("negate: 1\n"), negated);
  EXPECT_EQ(percents("negate: true\n"), negated);
}

TEST_F(ImageMap, OfScaleModeGradesWhatLiesBetweenTheThresholds) {
  write_pgm();
  // 0x80: occupancy 1 − 128 / 255 = 0.498, of the way from 0.19 to 0.65: 67 %; 0xcd: 0.196, 1 %.
  EXPECT_EQ(percents("mode: scale\n"), (std::vector<int>{67, 100, 0, 0, 100, 1}));
}

TEST_F(ImageMap, OfRawModeHoldsPercents) {
  write("room.pgm", "P2 3 2 255\n0 50 100\n101 255 42\n");
  EXPECT_EQ(percents("mode: raw\n"), (std::vector<int>{-1, -1, 42, 0, 50, 100}));
}

TEST_F(ImageMap, IgnoresKeysThatMapServerDoesNotKnow) {
  write_pgm();
  EXPECT_EQ(complaint(write_yaml("cost_translation_table: {}\n")), "");
}

TEST_F(ImageMap, MayBeAPngOfGreyColorsAPaletteOr16Bits) {
  const std::vector<int> expected{0, 100};
  write_png("grey.png", PNG_FORMAT_GRAY, 2, {255, 0});
  write_png("rgb.png", PNG_FORMAT_RGB, 2, {255, 255, 250, 3, 0, 0});
  write_png("rgba.png", PNG_FORMAT_RGBA, 2, {255, 255, 255, 255, 0, 0, 0, 255});
  for (const char* name : {"grey.png", "rgb.png", "rgba.png"}) {
    const auto plane = load_image_map(write_yaml("", name));
    EXPECT_EQ((std::vector<int>{plane.percent.begin(), plane.percent.end()}), expected) << name;
  }
}

// As map_server: in trinary mode the opacity is one colour more, in scale mode it decides.
TEST_F(ImageMap, TakesTransparentPixelsAsMapServerDoes) {
  write_png("ga.png", PNG_FORMAT_GA, 3, {0, 255, 0, 0, 255, 0});
  const auto read = [&](const std::string& mode) {
    const auto plane = load_image_map(write_yaml("mode: " + mode + "\n", "ga.png"));
    return std::vector<int>{plane.percent.begin(), plane.percent.end()};
  };
  EXPECT_EQ(read("trinary"), (std::vector<int>{100, 100, -1}));  // occupancies 0.75, 1, 0.25
  EXPECT_EQ(read("scale"), (std::vector<int>{100, -1, -1}));
}

TEST_F(ImageMap, BecomesAnOctomapWithTheSameSlice) {
  write_pgm();
  const auto file = write_yaml("");
  const Grid grid = slice(*load_map(file), {});
  EXPECT_EQ(grid.width, 2);
  EXPECT_EQ(grid.height, 3);
  EXPECT_EQ(grid.origin, (Eigen::Vector2d{-1.0, 2.0}));
  EXPECT_EQ(grid.cells, to_grid(load_image_map(file)).cells);
  double low[3], high[3];
  load_map(file, 1.0)->getMetricMin(low[0], low[1], low[2]);
  load_map(file, 1.0)->getMetricMax(high[0], high[1], high[2]);
  EXPECT_EQ(low[2], 0.0);
  EXPECT_EQ(high[2], 1.0);
}

TEST_F(ImageMap, TurnedByItsYawKeepsEveryWall) {
  write("room.pgm", "P2 3 2 255\n255 0 255\n255 255 205\n");
  const auto turned = [&](const std::string& yaw) {
    return to_grid(load_image_map(write_yaml("", "room.pgm", "[1.0, 0.0, " + yaw + "]")));
  };
  const Grid quarter = turned("1.5707963267948966");  // O's x axis is M's y axis
  EXPECT_EQ(quarter.width, 2);
  EXPECT_EQ(quarter.height, 3);
  EXPECT_NEAR(quarter.origin.x(), 0.0, 1e-9);
  using enum Cell;
  EXPECT_EQ(quarter.cells, (std::vector{kFree, kFree, kOccupied, kFree, kFree, kUnknown}));
  const Grid slanted = turned("0.5");
  const Eigen::Vector2d p_MC = transform(Pose2{1.0, 0.0, 0.5}, {0.75, 0.75});  // of the wall
  for (int iy = 0; iy < slanted.height; ++iy)
    for (int ix = 0; ix < slanted.width; ++ix) {
      const double distance = (slanted.center(ix, iy) - p_MC).norm();
      if (distance < 0.5) {
        EXPECT_EQ(slanted.at(ix, iy), kOccupied) << ix << " " << iy;
      }
      if (distance > std::numbers::sqrt2 * 0.5) {
        EXPECT_NE(slanted.at(ix, iy), kOccupied) << ix << " " << iy;
      }
    }
}

TEST_F(ImageMap, ErrorsNameWhatIsWrongInOneLine) {
  write_pgm();
  const auto expect = [&](const fs::path& file, const std::string& part) {
    EXPECT_NE(complaint(file).find(part), std::string::npos) << complaint(file);
  };
  expect(write_yaml("mode: bright\n"), "trinary, scale or raw");
  expect(write_yaml("negate: maybe\n"), "true or false");
  expect(write_yaml("", "missing.pgm"), "missing.pgm: no such file");
  write("comma.yaml", ",image: room.pgm\nresolution: 0.5\n");
  expect(folder_ / "comma.yaml", "stray comma or bracket");
  expect(write_yaml("", "room.pgm", "[0, 0]"), "[3 numbers]");
  expect(write_yaml("", "room.pgm", "[0, 0, .nan]"), "outside");
  expect(write_yaml("", "room.yaml"), "neither PGM");
  write("half.yaml", "image: room.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n");
  expect(folder_ / "half.yaml", ":1: `free_thresh` is missing");
  write("white.pgm", "P2 1 1 255 255");
  expect(write_yaml("", "white.pgm"), "no occupied cell");
}

TEST_F(ImageMap, OfADamagedImageIsRefusedWithoutTakingMemoryForIt) {
  for (const char* header : {"P5 100000 10000 255\n", "P5 1000000000 1 255\n", "P5 0 3 255\n",
                             "P2 2 2 0\n", "P5 99999999999 1 255\n", "P5 10000 10000 255\n",
                             "P2 10000 10000 255\n", "P5 2\n", "P5 -1 1 255\n", "P5 2 2 70000\n"}) {
    write("room.pgm", std::string{header} + "123");
    EXPECT_NE(complaint(write_yaml("")).find("room.pgm: "), std::string::npos) << header;
  }
  write_png("room.png", PNG_FORMAT_GRAY, 2, {255, 0, 255, 0});
  std::ifstream stream{folder_ / "room.png", std::ios::binary};
  const std::string good{std::istreambuf_iterator<char>(stream), {}};
  for (std::size_t length = 0; length < good.size() - 12; ++length) {  // IEND may be missing
    write("room.png", good.substr(0, length));
    EXPECT_NE(complaint(write_yaml("", "room.png")), "") << length;
  }
}

TEST_F(ImageMap, SurvivesAnyDamage) {
  const auto bytes_of = [&](const std::string& name) {
    std::ifstream stream{folder_ / name, std::ios::binary};
    return std::string{std::istreambuf_iterator<char>(stream), {}};
  };
  write_pgm();
  write_png("room.png", PNG_FORMAT_RGBA, 2, {255, 255, 255, 255, 0, 0, 0, 255});
  const fs::path yaml = write_yaml("mode: scale\nnegate: 0\n");
  std::mt19937 random{3};
  for (const std::string name : {"room.pgm", "room.png", "room.yaml"}) {
    const std::string good = bytes_of(name);
    std::uniform_int_distribution<std::size_t> at(0, good.size() - 1);
    std::uniform_int_distribution<int> byte(0, 255);
    if (name == "room.png") (void)write_yaml("", name);
    for (int i = 0; i < 300; ++i) {
      std::string bad = good;
      for (int k = 0; k <= i % 4; ++k) bad[at(random)] = static_cast<char>(byte(random));
      write(name, bad);
      (void)complaint(yaml);
    }
    write(name, good);
    (void)write_yaml("mode: scale\nnegate: 0\n");
  }
}

TEST(GrayImage, ScalesAnyWhiteToTheSame) {
  const fs::path file = fs::temp_directory_path() / ("tandem_gray_" + std::to_string(getpid()));
  std::ofstream{file} << "P2\n3 1\n# what is white\n100\n0 50\t100";
  EXPECT_EQ(read_gray_image(file).shade, (std::vector<std::uint16_t>{0, 32768, 65535}));
  std::ofstream{file, std::ios::binary} << "P5 2 1 1000\n" << std::string{"\x03\xe8\x00\x00", 4};
  EXPECT_EQ(read_gray_image(file).shade, (std::vector<std::uint16_t>{65535, 0}));
  fs::remove(file);
}

TEST(Extrude, KeepsEveryWallOfCellsThatLieBetweenVoxels) {
  Grid grid{0.1, {0.03, -0.05}, 3, 1, {Cell::kFree, Cell::kOccupied, Cell::kUnknown}};
  const Grid sliced = slice(*extrude(grid, 1.0), {});
  EXPECT_NEAR(sliced.origin.x(), 0.0, 1e-9);
  using enum Cell;
  EXPECT_EQ(sliced.cells, (std::vector{kFree, kOccupied, kOccupied, kFree, kOccupied, kOccupied}));
}

TEST(Extrude, CostsNoMoreForALargeHallThanItsWallsDo) {
  Grid grid{0.05, {-100.0, -100.0}, 4000, 4000, std::vector<Cell>(16'000'000, Cell::kFree)};
  for (std::size_t i = 0; i < 4000; ++i) grid.cells[i] = Cell::kOccupied;
  const auto tree = extrude(grid, 2.0);
  EXPECT_LT(tree->size(), 2'000'000U);
  EXPECT_EQ(slice(*tree, {}).cells, grid.cells);
}

TEST(Extrude, RefusesMapsBeyondTheRangeOfAnOctomap) {
  const Grid grid{0.05, {1.0e4, 0.0}, 1, 1, {Cell::kOccupied}};
  EXPECT_THROW((void)extrude(grid, 1.0), std::runtime_error);
}

TEST(ImageMaps, OfUsersIsARoomWithWallsAllRound) {
  const fs::path file = test::shared_path("cases/room.yaml");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here";
  const Grid grid = slice(*load_map(file), {});
  EXPECT_EQ(grid.width, 40);
  EXPECT_EQ(grid.height, 40);
  EXPECT_NEAR(grid.origin.x(), -2.0, 1e-9);
  EXPECT_EQ(grid.at(0, 0), Cell::kOccupied);
  EXPECT_EQ(grid.at(20, 20), Cell::kFree);
}

}  // namespace
}  // namespace tandem
