// SPDX-License-Identifier: Apache-2.0
#include "bringup/urdf/stl_file.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <istream>
#include <limits>
#include <stdexcept>
#include <string>

namespace tandem {
namespace {

constexpr std::size_t kHeader = 80, kTriangle = 50;  // [bytes] of a binary file

void add(const Eigen::Vector3d& vertex, Eigen::AlignedBox3d& box) {
  if (!vertex.allFinite()) throw std::runtime_error("has a vertex that is not finite");
  box.extend(vertex);
}

// A triangle consists of 12 floats, the normal and three vertices, and two further bytes.
Eigen::AlignedBox3d read_binary(std::istream& in, std::uint32_t triangles) {
  Eigen::AlignedBox3d box;
  std::array<char, kTriangle> bytes{};
  for (std::uint32_t i = 0; i < triangles && in.read(bytes.data(), kTriangle); ++i) {
    std::array<float, 12> numbers{};
    std::memcpy(numbers.data(), bytes.data(), sizeof numbers);
    for (std::size_t v = 3; v < numbers.size(); v += 3)
      add(Eigen::Vector3d{numbers[v], numbers[v + 1], numbers[v + 2]}, box);
  }
  return box;
}

Eigen::AlignedBox3d read_text(std::istream& in) {
  Eigen::AlignedBox3d box;
  std::string word;
  bool is_complete = false;
  while (in >> word) {
    is_complete = word == "endsolid";
    if (is_complete || word == "solid")  // and its name
      in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    Eigen::Vector3d vertex;
    if (word == "vertex" && in >> vertex.x() >> vertex.y() >> vertex.z()) add(vertex, box);
  }
  if (!is_complete) throw std::runtime_error("is not a complete STL file");
  return box;
}

}  // namespace

Eigen::AlignedBox3d stl_bounding_box(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  std::array<char, kHeader> header{};
  std::uint32_t triangles = 0;
  in.read(header.data(), kHeader).read(reinterpret_cast<char*>(&triangles), sizeof triangles);
  // Some binary files begin with "solid" as those of text do, so only the size decides.
  const bool is_binary =
      in && std::filesystem::file_size(file) ==
                kHeader + sizeof triangles + std::uintmax_t{triangles} * kTriangle;
  if (!is_binary) {
    in.clear();
    in.seekg(0);
  }
  if (!in) throw std::runtime_error("cannot be read");
  const Eigen::AlignedBox3d box = is_binary ? read_binary(in, triangles) : read_text(in);
  if (box.isEmpty()) throw std::runtime_error("has no vertices");
  return box;
}

}  // namespace tandem
