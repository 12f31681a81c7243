// SPDX-License-Identifier: Apache-2.0
// Draws a map with obstacles, paths and footprints as a PNG.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

struct Color {
  double r = 0.0, g = 0.0, b = 0.0, alpha = 1.0;
};

namespace colors {
inline constexpr Color kShape{0.91, 0.45, 0.05};    ///< fitted obstacles: orange
inline constexpr Color kRobot{0.10, 0.37, 0.75};    ///< the robot and its path: blue
inline constexpr Color kLeader{0.55, 0.20, 0.62};   ///< the person's leader: purple
inline constexpr Color kWalker{0.40, 0.42, 0.45};   ///< people and their paths: grey
inline constexpr Color kPlan{0.05, 0.60, 0.50};     ///< planned poses: teal
inline constexpr Color kGoal{0.20, 0.62, 0.25};     ///< goal region: green
inline constexpr Color kContact{0.84, 0.12, 0.15};  ///< collisions: red
}  // namespace colors

/// How a line or outline is drawn. Lengths in pixels.
struct Pen {
  Color color;
  double width = 2.0;
  double dash = 0.0;            ///< length of dashes and gaps; 0: solid
  std::optional<Color> fill{};  ///< inside of closed shapes
  std::string label{};          ///< entry in the legend, once per label; empty: none
};

/// Rectangle of the plane, corners in M [m].
struct Area {
  Eigen::Vector2d low, high;
};

/// Picture of a map seen from above, x to the right and y up. Later drawings cover earlier ones.
/// All positions in M [m].
class MapPicture {
 public:
  /// Shows the grid, or the part of it inside `area`, scaled to fit `max_pixels` in both
  /// directions. Throws std::invalid_argument if the grid or the area is empty.
  explicit MapPicture(const Grid& grid, std::optional<Area> area = std::nullopt,
                      int max_pixels = 1400);
  ~MapPicture();
  MapPicture(MapPicture&&) noexcept;
  MapPicture& operator=(MapPicture&&) noexcept;

  void draw_obstacles(std::span<const Obstacle> obstacles, const Pen& pen);
  void draw_path(std::span<const Eigen::Vector2d> points, const Pen& pen);
  void draw_path(std::span<const Pose2> X_MB, const Pen& pen);
  void draw_footprint(const Footprint& footprint, const Pose2& X_MB, const Pen& pen);
  void draw_circle(const Eigen::Vector2d& p_MC, double radius, const Pen& pen);
  void draw_rectangle(const Area& area, const Pen& pen);
  /// Draws a filled dot with a diameter of `pen.width` pixels.
  void draw_point(const Eigen::Vector2d& p_MQ, const Pen& pen);
  /// Draws text with a white halo; its lower left corner is at the point.
  void draw_text(const Eigen::Vector2d& p_MQ, const std::string& text, const Color& color);

  /// Sets the line above the map.
  void set_title(const std::string& title);

  /// Pixel of a point, from the upper left corner of the picture.
  [[nodiscard]] Eigen::Vector2d to_pixel(const Eigen::Vector2d& p_MQ) const;
  [[nodiscard]] double pixels_per_metre() const;

  /// Adds title, scale bar and legend and writes the file. Throws std::runtime_error naming it.
  void write_png(const std::filesystem::path& file);

 private:
  struct Canvas;  // hides cairo from other translation units
  std::unique_ptr<Canvas> canvas_;
};

}  // namespace tandem
