// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/octomap_file.hpp"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTreeStamped.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <random>
#include <sstream>

#include "support/paths.hpp"
#include "tandem/map/octomap_bytes.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// A separate file for each test, removed afterwards.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& bytes)
      : path_{fs::temp_directory_path() / ("tandem_octomap_test_" + std::to_string(getpid()))} {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~TemporaryFile() { fs::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

octomap::OcTree small_tree(unsigned seed = 1) {
  octomap::OcTree tree(0.1);
  std::mt19937 random{seed};
  std::uniform_real_distribution<float> metre(-1.0F, 1.0F);
  for (int i = 0; i < 60; ++i)
    tree.updateNode(octomap::point3d(metre(random), metre(random), metre(random)), i % 3 == 0);
  tree.updateInnerOccupancy();
  return tree;
}

std::string ot_bytes(const octomap::OcTree& tree) {
  std::ostringstream stream;
  tree.write(stream);
  return stream.str();
}

// A tree of another type with the same occupancy.
template <class Tree>
Tree same_as(const octomap::OcTree& plain) {
  Tree tree(plain.getResolution());
  for (auto leaf = plain.begin_leafs(); leaf != plain.end_leafs(); ++leaf)
    tree.setNodeValue(leaf.getKey(), leaf->getLogOdds());
  tree.updateInnerOccupancy();
  return tree;
}

octomap::ColorOcTree colored(const octomap::OcTree& plain) {
  auto tree = same_as<octomap::ColorOcTree>(plain);
  std::uint8_t shade = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, shade += 7)
    leaf->setColor({shade, 0, 255});
  return tree;
}

template <class Tree>
std::string full_file(const Tree& tree) {
  std::ostringstream stream;
  tree.write(stream);
  return stream.str();
}

template <class Tree>
std::string binary_file(const Tree& tree) {
  std::ostringstream stream;
  tree.writeBinaryConst(stream);
  return stream.str();
}

template <class Tree>
std::vector<std::int8_t> full_data(const Tree& tree) {
  std::ostringstream stream;
  tree.writeData(stream);
  const std::string bytes = stream.str();
  return {bytes.begin(), bytes.end()};
}

// The format that OctoMap wrote before 1.0.
std::string legacy_file(const octomap::OcTree& tree) {
  const std::int32_t type = 3;
  const double resolution = tree.getResolution();
  const auto nodes = static_cast<std::uint32_t>(tree.size());
  std::ostringstream stream;
  stream.write(reinterpret_cast<const char*>(&type), sizeof type);
  stream.write(reinterpret_cast<const char*>(&resolution), sizeof resolution);
  stream.write(reinterpret_cast<const char*>(&nodes), sizeof nodes);
  tree.writeBinaryData(stream);
  return stream.str();
}

std::unique_ptr<octomap::OcTree> load_bytes(const std::string& bytes) {
  const TemporaryFile file(bytes);
  return load_octomap(file.path());
}

// load_octomap's error message for a file with these bytes; empty if it loads.
std::string complaint_of_file(const std::string& bytes) {
  const TemporaryFile file(bytes);
  try {
    const auto tree = load_octomap(file.path());
    return tree ? "" : "no tree";
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with(file.path().string() + ": ")) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
    return text;
  }
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

// The map of a user's file as .bt; empty if the file does not exist.
std::optional<std::string> binary_leaves(const std::string& name) {
  const auto file = test::shared_path("cases/" + name);
  if (!fs::exists(file)) return std::nullopt;
  auto tree = load_octomap(file);
  tree->toMaxLikelihood();
  tree->prune();
  return bt_file_bytes(*tree);
}

TEST(OctomapFile, ReadsBackWhatItWrote) {
  const octomap::OcTree tree = small_tree();
  const TemporaryFile file("");
  save_octomap(tree, file.path());
  const auto copy = load_octomap(file.path());
  EXPECT_EQ(copy->size(), tree.size());
  EXPECT_EQ(bt_file_bytes(*copy), bt_file_bytes(tree));
}

TEST(OctomapFile, WritesWhatOctomapItselfReads) {
  std::istringstream stream(bt_file_bytes(small_tree()));
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(stream));
  EXPECT_EQ(tree.getResolution(), 0.1);
  EXPECT_EQ(bt_file_bytes(tree), bt_file_bytes(small_tree()));
}

TEST(OctomapFile, ReadsLogOddsFiles) {
  const octomap::OcTree tree = small_tree();
  const TemporaryFile file(ot_bytes(tree));
  const auto copy = load_octomap(file.path());
  EXPECT_TRUE(*copy == tree);
}

TEST(OctomapFile, ReadsTheOccupancyOfAColoredTree) {
  const octomap::OcTree tree = small_tree();
  EXPECT_TRUE(*load_bytes(full_file(colored(tree))) == tree);
  EXPECT_EQ(bt_file_bytes(*load_bytes(binary_file(colored(tree)))), bt_file_bytes(tree));
}

TEST(OctomapFile, ReadsTheOccupancyOfAStampedTree) {
  const octomap::OcTree tree = small_tree();
  const auto stamped = same_as<octomap::OcTreeStamped>(tree);
  EXPECT_TRUE(*load_bytes(full_file(stamped)) == tree);
  EXPECT_EQ(bt_file_bytes(*load_bytes(binary_file(stamped))), bt_file_bytes(tree));
}

TEST(OctomapFile, ReadsAFileFromBeforeVersionOne) {
  const octomap::OcTree tree = small_tree();
  EXPECT_EQ(bt_file_bytes(*load_bytes(legacy_file(tree))), bt_file_bytes(tree));
  EXPECT_TRUE(*load_bytes(replaced(ot_bytes(tree), "id OcTree", "id 1")) == tree);
}

TEST(OctomapFile, ReadsAFullTreeWhateverSizeItsHeaderGives) {
  const octomap::OcTree tree = small_tree();
  const std::string size = "size " + std::to_string(tree.size()) + "\n";
  for (const char* other : {"size 1\n", "size 0\n", "size 1000000000\n", ""})
    EXPECT_TRUE(*load_bytes(replaced(ot_bytes(tree), size, other)) == tree) << other;
}

TEST(OctomapFile, ReadsAHeaderWhoseKeysShareALine) {
  const octomap::OcTree tree = small_tree();
  const std::string file = replaced(replaced(ot_bytes(tree), "id OcTree\n", "id\tOcTree "),
                                    "res 0.1\n", "scale 3 of another program\nres .1\n");
  EXPECT_TRUE(*load_bytes(file) == tree);
}

TEST(OctomapFile, TakesInfiniteLogOddsForCertainAndRefusesNan) {
  constexpr float kCertain = std::numeric_limits<float>::infinity();
  octomap::OcTree tree(0.1);
  tree.setNodeValue(octomap::point3d(1, 0, 0), kCertain);
  tree.setNodeValue(octomap::point3d(2, 0, 0), -kCertain);
  const auto copy = load_bytes(ot_bytes(tree));
  EXPECT_TRUE(copy->isNodeOccupied(copy->search(1, 0, 0)));
  EXPECT_FALSE(copy->isNodeOccupied(copy->search(2, 0, 0)));
  tree.setNodeValue(octomap::point3d(3, 0, 0), std::numeric_limits<float>::quiet_NaN());
  EXPECT_NE(complaint_of_file(ot_bytes(tree)), "");
}

TEST(OctomapFile, ReadsTheFilesThatUsersSent) {
  const auto expected = binary_leaves("color.bt");
  if (!expected) GTEST_SKIP() << "the files are not here";
  for (const char* name : {"color.ot", "legacy.bt", "size0.ot"})
    EXPECT_EQ(binary_leaves(name), expected) << name;
}

TEST(OctomapFile, RefusesATruncatedFileOfAnyLength) {
  for (const std::string& bytes : {bt_file_bytes(small_tree()), ot_bytes(small_tree()),
                                   full_file(colored(small_tree())), legacy_file(small_tree())}) {
    ASSERT_EQ(complaint_of_file(bytes), "");
    for (std::size_t length = 0; length < bytes.size(); ++length)
      ASSERT_NE(complaint_of_file(bytes.substr(0, length)), "") << length << " of " << bytes.size();
  }
}

TEST(OctomapFile, RefusesBytesBeyondTheTree) {
  EXPECT_NE(complaint_of_file(bt_file_bytes(small_tree()) + "x"), "");
  EXPECT_NE(complaint_of_file(ot_bytes(small_tree()) + std::string(5, '\0')), "");
}

TEST(OctomapFile, RefusesPathsThatAreNotFiles) {
  EXPECT_THROW((void)load_octomap("/nonexistent/map.bt"), std::runtime_error);
  EXPECT_THROW((void)load_octomap(fs::temp_directory_path()), std::runtime_error);
}

TEST(OctomapFile, RefusesFilesThatAreNotOctomaps) {
  EXPECT_NE(complaint_of_file("P5 100 100 255\n").find("not an OctoMap file"), std::string::npos);
  EXPECT_NE(complaint_of_file(std::string(3000, '\xff')).find("not an OctoMap file"),
            std::string::npos);
}

TEST(OctomapFile, RefusesAHostileHeader) {
  const std::string good = bt_file_bytes(small_tree());
  const std::string size = "size " + std::to_string(small_tree().size());
  for (const char* res :
       {"res 0\n", "res nan\n", "res inf\n", "res -0.1\n", "res 1e9\n", "res x\n"})
    EXPECT_NE(complaint_of_file(replaced(good, "res 0.1\n", res)), "") << res;
  for (const char* wrong :
       {"size 1000000000", "size 0", "size -1", "size", "size 99999999999999999999"})
    EXPECT_NE(complaint_of_file(replaced(good, size, wrong)), "") << wrong;
  const std::string counts = replaced(ot_bytes(small_tree()), "id OcTree", "id CountingOcTree");
  EXPECT_NE(complaint_of_file(counts).find("CountingOcTree"), std::string::npos);
  for (const char* nameless : {"id ", "id\n", ""})
    EXPECT_NE(complaint_of_file(replaced(good, "id OcTree\n", nameless)), "") << nameless;
}

TEST(OctomapFile, RefusesAMapWithoutOccupiedVoxels) {
  octomap::OcTree tree(0.1);
  EXPECT_NE(complaint_of_file(bt_file_bytes(tree)).find("empty"), std::string::npos);
  tree.updateNode(octomap::point3d(0, 0, 0), false);
  EXPECT_NE(complaint_of_file(bt_file_bytes(tree)).find("no occupied voxel"), std::string::npos);
}

TEST(OctomapFile, ToleratesCommentsAndCarriageReturnsInTheHeader) {
  const std::string good = bt_file_bytes(small_tree());
  EXPECT_EQ(complaint_of_file(replaced(good, "id OcTree\n", "# made by hand\nid OcTree\r\n")), "");
}

TEST(OctomapMessage, RoundTripsBinaryData) {
  const octomap::OcTree tree = small_tree();
  const auto data = encode_octomap(tree);
  const DecodedOctomap decoded = decode_octomap({.resolution = 0.1}, data);
  ASSERT_TRUE(decoded.tree) << decoded.error;
  EXPECT_EQ(bt_file_bytes(*decoded.tree), bt_file_bytes(tree));
}

TEST(OctomapMessage, ReadsTheTreesThatOctomapMsgsSends) {
  const octomap::OcTree tree = small_tree();
  const auto color = full_data(colored(tree));
  const auto decoded =
      decode_octomap({.id = "ColorOcTree", .binary = false, .resolution = 0.1}, color);
  ASSERT_TRUE(decoded.tree) << decoded.error;
  EXPECT_TRUE(*decoded.tree == tree);
  const auto stamped =
      decode_octomap({.id = "OcTreeStamped", .binary = false, .resolution = 0.1}, full_data(tree));
  ASSERT_TRUE(stamped.tree) << stamped.error;
  EXPECT_TRUE(*stamped.tree == tree);
  for (const char* id : {"ColorOcTree", "OcTreeStamped", "", "OfAnotherProgram"}) {
    const auto binary = decode_octomap({.id = id, .resolution = 0.1}, encode_octomap(tree));
    ASSERT_TRUE(binary.tree) << id << ": " << binary.error;
    EXPECT_EQ(bt_file_bytes(*binary.tree), bt_file_bytes(tree));
  }
}

TEST(OctomapMessage, SurvivesAnyDamage) {
  const auto good = encode_octomap(small_tree());
  std::mt19937 random{2};
  std::uniform_int_distribution<std::size_t> at(0, good.size() - 1);
  std::uniform_int_distribution<int> byte(-128, 127);
  for (int i = 0; i < 20000; ++i) {
    auto data = good;
    for (int k = 0; k <= i % 4; ++k) data[at(random)] = static_cast<std::int8_t>(byte(random));
    if (i % 3 == 0) data.resize(at(random));
    const OctomapFormat format{.binary = i % 5 != 0, .resolution = 0.1};
    const DecodedOctomap decoded = decode_octomap(format, data);
    ASSERT_NE(decoded.tree == nullptr, decoded.error.empty());
    if (decoded.tree) continue;
    try {
      (void)slice_octomap(format, data, {});
      FAIL() << "sliced although " << decoded.error;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), decoded.error);
    }
  }
}

TEST(OctomapMessage, RefusesWhatItsFieldsContradict) {
  const auto data = encode_octomap(small_tree());
  EXPECT_FALSE(
      decode_octomap({.id = "CountingOcTree", .binary = false, .resolution = 0.1}, data).tree);
  EXPECT_FALSE(
      decode_octomap({.id = "ColorOcTree", .binary = false, .resolution = 0.1}, data).tree);
  EXPECT_FALSE(decode_octomap({.resolution = 0.0}, data).tree);
  EXPECT_FALSE(decode_octomap({.resolution = std::nan("")}, data).tree);
  EXPECT_FALSE(decode_octomap({.resolution = 0.1}, {}).tree);
}

TEST(OctomapMessage, RefusesATreeDeeperThanOctomaps) {
  std::vector<std::int8_t> data;  // one inner child per level, without end
  for (int level = 0; level < 100000; ++level) data.insert(data.end(), {3, 0});
  EXPECT_FALSE(decode_octomap({.resolution = 0.1}, data).tree);
}

TEST(OctomapBytes, CountsTheNodesOfATree) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const octomap::OcTree tree = small_tree(seed);
    std::ostringstream binary, full;
    tree.writeBinaryData(binary);
    tree.writeData(full);
    EXPECT_EQ(count_binary_nodes(binary.str()), tree.size());
    EXPECT_EQ(count_full_nodes(full.str()), tree.size());
  }
}

}  // namespace
}  // namespace tandem
