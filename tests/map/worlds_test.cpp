// SPDX-License-Identifier: Apache-2.0
// Tests cluttered worlds: BARN's from files, and generated ones from seeds.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "support/instrumented.hpp"
#include "support/paths.hpp"
#include "tandem/map/barn_world.hpp"
#include "tandem/map/clutter_world.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const std::string kMeta = R"("meta": {"cylinder_radius_m": 0.075, "start": {"x": 1, "y": 1},
                                      "goal": {"x": 1, "y": 5}})";

// A temporary file with the given text.
class File {
 public:
  explicit File(const std::string& text)
      : path_{fs::temp_directory_path() / ("tandem_barn_" + std::to_string(getpid()))} {
    std::ofstream(path_) << text;
  }
  ~File() { fs::remove(path_); }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string complaint(const std::string& text, int number) {
  const File file(text);
  try {
    (void)load_barn_world(file.path(), number);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

StaticMap plane(const MapDescription& world) { return StaticMap(slice(*build_octomap(world), {})); }

TEST(BarnWorld, HasItsCylindersAtTheirPlaces) {
  const File file(
      "{" + kMeta +
      R"(, "worlds": {"3": {"cylinders": [[0.075, 2.025]]}, "12": {"cylinders": [[0.075, 0.075]]}}})");
  EXPECT_EQ(barn_world_numbers(file.path()), (std::vector<int>{3, 12}));
  const StaticMap map = plane(load_barn_world(file.path(), 3));
  const auto cells = map.cells_near({1.0, 3.0}, 9.0);
  ASSERT_EQ(cells.size(), 9);  // 3 × 3 cells of 0.05 m
  Eigen::Vector2d middle{0.0, 0.0};
  for (const auto& p_MC : cells) middle += p_MC / 9.0;
  EXPECT_LT((middle - Eigen::Vector2d{0.075, 2.025}).norm(), 1e-9);
  EXPECT_TRUE(map.can_pass({1.0, 1.0}, {1.0, 5.0}, 0.5));
}

TEST(BarnWorld, HasTheLengthOfItsReferenceWayFromStartToGoal) {
  const File file("{" + kMeta + R"(, "worlds": {"3": {"cylinders": [],
      "reference_path": [[1, 2], [4, 2], [4, 5]]}, "12": {"cylinders": []}}})");
  EXPECT_DOUBLE_EQ(barn_way_length(file.path(), 3).value(), 1.0 + 3.0 + 3.0 + 3.0);
  EXPECT_FALSE(barn_way_length(file.path(), 12).has_value());
  EXPECT_EQ(barn_world_number(file.path(), 1), 3);
  EXPECT_EQ(barn_world_number(file.path(), 2), 12);
  EXPECT_EQ(barn_world_number(file.path(), 3), 3);
}

TEST(BarnWorld, ErrorsNameWhatIsWrong) {
  EXPECT_NE(complaint("", 1).find("not a BARN world file"), std::string::npos);
  EXPECT_NE(complaint("[1, 2]", 1).find("not a BARN world file"), std::string::npos);
  EXPECT_NE(complaint("{" + kMeta + R"(, "worlds": {"3": {"cylinders": []}}})", 4)
                .find("no world 4; it has 1, next to it 3"),
            std::string::npos);
  for (const char* world :
       {R"({"cylinders": []})", R"({})", R"({"cylinders": [["a", 1]]})",
        R"({"cylinders": [[1e9, 1]]})", R"({"cylinders": [[999, 999], [-999, -999]]})", "7"}) {
    const std::string text = complaint("{" + kMeta + R"(, "worlds": {"3": )" + world + "}}", 3);
    EXPECT_NE(text.find("world 3"), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
  EXPECT_THROW((void)load_barn_world("/nonexistent.json", 1), std::runtime_error);
}

TEST(BarnWorld, AllOfTheFileCanBePassed) {
  const auto file = test::shared_path("barn/worlds.json");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here";
  const auto numbers = barn_world_numbers(file);
  ASSERT_EQ(numbers.size(), 150);
  for (std::size_t i = 0; i < numbers.size(); i += test::samples(15, 50))
    EXPECT_TRUE(
        plane(load_barn_world(file, numbers[i])).can_pass({-2.25, 3.0}, {-2.25, 13.0}, 0.17))
        << "world " << numbers[i];
}

TEST(ClutterWorld, CanBePassedByTheRobotItIsMadeFor) {
  for (unsigned seed = 0; seed < test::samples(10, 2); ++seed)
    for (const double width : {0.5, 0.8}) {
      const StaticMap map = plane(clutter_world(seed, {.width = width}));
      EXPECT_TRUE(map.can_pass(kClutterStart, kClutterGoal, 0.5 * width)) << seed;
    }
}

TEST(ClutterWorld, IsTheSameForTheSameSeed) {
  const auto bytes = [](unsigned seed) {
    return bt_file_bytes(*build_octomap(clutter_world(seed, {})));
  };
  EXPECT_EQ(bytes(4), bytes(4));
  EXPECT_NE(bytes(4), bytes(5));
}

TEST(ClutterWorld, IsClutteredLikeBarn) {
  std::size_t cylinders = 0;
  for (unsigned seed = 0; seed < 10; ++seed) cylinders += clutter_world(seed, {}).solids.size();
  EXPECT_GT(cylinders, 10 * 200);  // 150 of them walls; BARN's median is 268
  EXPECT_LT(cylinders, 10 * 350);
}

TEST(ClutterWorld, FailsIfNoWorldCanBePassed) {
  EXPECT_THROW((void)clutter_world(1, {.fill = 0.6, .width = 1.5}), std::runtime_error);
  EXPECT_THROW((void)clutter_world(1, {.fill = 7.0}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
