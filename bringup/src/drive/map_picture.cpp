// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/map_picture.hpp"

#include <cairo.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "bringup/drive/map_canvas.hpp"

#if defined(__SANITIZE_ADDRESS__)
// Fontconfig keeps its cache until the process ends, which LeakSanitizer would report.
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }
#endif

namespace tandem {

MapPicture::MapPicture(const Grid& grid, std::optional<Area> area, int max_pixels) {
  if (grid.cells.empty()) throw std::invalid_argument("picture: the map has no cells");
  const Area shown = area.value_or(grid_area(grid));
  const Eigen::Vector2d size = shown.high - shown.low;
  if (!(size.minCoeff() > 0.0) || !size.allFinite())
    throw std::invalid_argument("picture: the area is empty");
  const double room = std::max(100.0, max_pixels - kTitle - kMargin - kFooter);
  canvas_ = std::make_unique<Canvas>(shown, room / size.maxCoeff());
  canvas_->draw_grid(grid);
}
MapPicture::~MapPicture() = default;
MapPicture::MapPicture(MapPicture&&) noexcept = default;
MapPicture& MapPicture::operator=(MapPicture&&) noexcept = default;

void MapPicture::draw_obstacles(std::span<const Obstacle> obstacles, const Pen& pen) {
  cairo_t* const cairo = canvas_->cairo.get();
  for (const Obstacle& obstacle : obstacles) {
    const Eigen::Vector2d pixel = to_pixel(obstacle.p_MO);
    cairo_save(cairo);
    cairo_translate(cairo, pixel.x(), pixel.y());
    cairo_rotate(cairo, -obstacle.angle);
    cairo_scale(cairo, canvas_->scale * obstacle.a, canvas_->scale * obstacle.b);
    cairo_new_sub_path(cairo);
    if (is_rectangle(obstacle))
      cairo_rectangle(cairo, -1.0, -1.0, 2.0, 2.0);
    else
      cairo_arc(cairo, 0.0, 0.0, 1.0, 0.0, 2.0 * std::numbers::pi);
    cairo_close_path(cairo);
    cairo_restore(cairo);
    canvas_->finish(pen);
  }
}

void MapPicture::draw_path(std::span<const Eigen::Vector2d> points, const Pen& pen) {
  canvas_->draw_polyline({points.begin(), points.end()}, false, pen);
}

void MapPicture::draw_path(std::span<const Pose2> X_MB, const Pen& pen) {
  std::vector<Eigen::Vector2d> points;
  for (const Pose2& X : X_MB) points.push_back(X.position());
  canvas_->draw_polyline(points, false, pen);
}

void MapPicture::draw_footprint(const Footprint& footprint, const Pose2& X_MB, const Pen& pen) {
  for (const auto& part : footprint.parts) {
    std::vector<Eigen::Vector2d> points;
    for (const auto& p_BV : part) points.push_back(transform(X_MB, p_BV));
    canvas_->add_polyline(points, true);
  }
  canvas_->finish(pen);  // all parts at once, so that overlaps are not filled twice
}

void MapPicture::draw_circle(const Eigen::Vector2d& p_MC, double radius, const Pen& pen) {
  Obstacle circle;
  circle.p_MO = p_MC;
  circle.a = circle.b = radius;
  draw_obstacles({&circle, 1}, pen);
}

void MapPicture::draw_rectangle(const Area& area, const Pen& pen) {
  canvas_->draw_polyline(
      {area.low, {area.high.x(), area.low.y()}, area.high, {area.low.x(), area.high.y()}}, true,
      pen);
}

void MapPicture::draw_point(const Eigen::Vector2d& p_MQ, const Pen& pen) {
  Pen dot = pen;
  dot.fill = pen.color;
  dot.width = 0.5;
  draw_circle(p_MQ, 0.5 * pen.width / canvas_->scale, dot);
}

void MapPicture::draw_text(const Eigen::Vector2d& p_MQ, const std::string& text,
                           const Color& color) {
  canvas_->write(text, to_pixel(p_MQ), color);
}

void MapPicture::set_title(const std::string& title) { canvas_->title = title; }

Eigen::Vector2d MapPicture::to_pixel(const Eigen::Vector2d& p_MQ) const {
  return canvas_->to_pixel(p_MQ);
}

double MapPicture::pixels_per_metre() const { return canvas_->scale; }

void MapPicture::write_png(const std::filesystem::path& file) {
  canvas_->write(canvas_->title, {kMargin, 0.65 * kTitle}, kInk);
  canvas_->draw_legend(canvas_->draw_scale_bar());
  const cairo_status_t status =
      cairo_surface_write_to_png(canvas_->surface.get(), file.string().c_str());
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(file.string() + ": cannot be written (" +
                             cairo_status_to_string(status) + ")");
}

}  // namespace tandem
