// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "bringup/urdf/stl_file.hpp"
#include "bringup/urdf/urdf_robot.hpp"
#include "bringup/urdf/urdf_text.hpp"

namespace tandem {
namespace {

// One triangle with corners at (−2, −1, 0), (4, 3, 1) and (0, 0, 0).
const std::string kText = R"(solid a vertex of no triangle
  facet normal 0 0 1
    outer loop
      vertex -2 -1 0
      vertex 4.0e0 3 1
      vertex 0 0 0
    endloop
  endfacet
endsolid a vertex
)";

// The same as a binary file, whose header begins with `header`.
std::string binary(const std::string& header = "") {
  const std::array<float, 12> numbers{0, 0, 1, -2, -1, 0, 4, 3, 1, 0, 0, 0};
  const std::uint32_t count = 1;
  std::string bytes = header;
  bytes.resize(80);
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
  return bytes + std::string(2, '\0');
}

class MeshTest : public testing::Test {
 protected:
  void expect_box(const std::string& content) {
    const Eigen::AlignedBox3d box = stl_bounding_box(folder_.write("mesh.stl", content));
    EXPECT_EQ(box.min(), Eigen::Vector3d(-2, -1, 0));
    EXPECT_EQ(box.max(), Eigen::Vector3d(4, 3, 1));
  }
  void expect_refused(const std::string& content) {
    const auto file = folder_.write("mesh.stl", content);
    EXPECT_THROW((void)stl_bounding_box(file), std::runtime_error) << content;
  }
  // A robot whose base_link is a mesh, in `package`/urdf/.
  std::filesystem::path robot(const std::string& uri, const std::string& package = "my_robot") {
    return folder_.write(
        package + "/urdf/robot.urdf",
        "<robot name=\"test\">" + test::wheels() +
            test::link("base_link", "<mesh filename=\"" + uri + "\" scale=\"0.1 0.1 0.1\"/>") +
            "</robot>");
  }
  void expect_mesh(const std::string& uri) {
    const Extent e = extent(polygon(read_urdf_robot(robot(uri)).outline));
    EXPECT_NEAR(e.front, 0.4, 1e-4) << uri;
    EXPECT_NEAR(e.left, 0.3, 1e-4) << uri;
  }
  void expect_error(const std::string& part, const std::string& uri) {
    try {
      (void)read_urdf_robot(robot(uri));
      ADD_FAILURE() << uri;
    } catch (const std::exception& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("link 'base_link': mesh " + uri + ": "), std::string::npos) << text;
      EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }

  test::UrdfFolder folder_;
};

TEST_F(MeshTest, TheBoxAroundAnStlFile) {
  expect_box(kText);
  expect_box(binary());
  expect_box(binary("solid as some programs write"));
}

TEST_F(MeshTest, DamagedStlFilesAreRefused) {
  expect_refused("");
  expect_refused("solid a\nendsolid a\n");
  expect_refused(kText.substr(0, kText.find("endloop")));
  expect_refused(binary().substr(0, 120));
  expect_refused(binary() + "x");
  std::string number = binary();
  number[84 + 12 + 3] = '\x7f', number[84 + 12 + 2] = '\xc0';  // NaN
  expect_refused(number);
  EXPECT_THROW((void)stl_bounding_box(folder_.path() / "none.stl"), std::runtime_error);
  EXPECT_THROW((void)stl_bounding_box(folder_.path()), std::runtime_error);
}

TEST_F(MeshTest, MeshesAreFoundBesideTheUrdfAndInPackages) {
  const auto file = folder_.write("my_robot/meshes/body.STL", binary());
  expect_mesh("../meshes/body.STL");
  expect_mesh("file://" + file.string());
  expect_mesh("package://my_robot/meshes/body.STL");
  folder_.write("prefix/share/their_robot/meshes/body.stl", kText);
  setenv("AMENT_PREFIX_PATH", ("/nowhere:" + (folder_.path() / "prefix").string()).c_str(), 1);
  expect_mesh("package://their_robot/meshes/body.stl");
  unsetenv("AMENT_PREFIX_PATH");
  expect_error("is package 'their_robot' installed", "package://their_robot/meshes/body.stl");
}

TEST_F(MeshTest, OtherMeshesAreNamed) {
  folder_.write("my_robot/meshes/body.dae", "<COLLADA/>");
  expect_error("only STL meshes can be read", "package://my_robot/meshes/body.dae");
  expect_error("only package:// and file://", "https://example.org/body.stl");
  expect_error("cannot be read", "none.stl");
  folder_.write("my_robot/meshes/cut.stl", binary().substr(0, 100));
  expect_error("not a complete STL file", "package://my_robot/meshes/cut.stl");
}

}  // namespace
}  // namespace tandem
