// SPDX-License-Identifier: Apache-2.0
// Draws shapes given in the map frame with cairo. Included by map_picture.cpp only.
#pragma once

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bringup/drive/map_picture.hpp"

namespace tandem {
namespace {

constexpr double kMargin = 16.0, kTitle = 34.0, kFooter = 44.0;  // around the map [pixels]
constexpr double kFontSize = 15.0;
constexpr Color kPaper{1.0, 1.0, 1.0}, kInk{0.15, 0.15, 0.17};

Color color_of(Cell cell) {
  switch (cell) {
    case Cell::kFree:
      return {1.0, 1.0, 1.0};
    case Cell::kOccupied:
      return {0.20, 0.21, 0.24};
    case Cell::kUnknown:
      return {0.88, 0.89, 0.90};
  }
  return {};
}

std::uint32_t to_rgb24(const Color& color) {
  const auto byte = [](double value) { return static_cast<std::uint32_t>(255.0 * value + 0.5); };
  return byte(color.r) << 16U | byte(color.g) << 8U | byte(color.b);
}

Area grid_area(const Grid& grid) {
  const Eigen::Vector2d size{grid.resolution * grid.width, grid.resolution * grid.height};
  return {grid.origin, grid.origin + size};
}

// Largest 1, 2 or 5 times a power of ten that does not exceed `length`.
double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double digit : {5.0, 2.0})
    if (digit * power <= length) return digit * power;
  return power;
}

std::string metres(double length) {
  std::string text = std::to_string(length);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text + " m";
}

}  // namespace

struct MapPicture::Canvas {
  Area area;
  double scale;  // pixels per metre
  int width, height;
  std::string title;
  std::vector<Pen> legend;
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo;

  Canvas(const Area& shown, double pixels_per_metre)
      : area{shown},
        scale{pixels_per_metre},
        width{static_cast<int>(std::ceil(scale * (area.high.x() - area.low.x()) + 2 * kMargin))},
        height{static_cast<int>(
            std::ceil(scale * (area.high.y() - area.low.y()) + kTitle + kMargin + kFooter))},
        surface{cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height),
                cairo_surface_destroy},
        cairo{cairo_create(surface.get()), cairo_destroy} {
    set_color(kPaper);
    cairo_paint(cairo.get());
    cairo_set_line_join(cairo.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cairo.get(), CAIRO_LINE_CAP_ROUND);
    cairo_select_font_face(cairo.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo.get(), kFontSize);
  }

  [[nodiscard]] Eigen::Vector2d to_pixel(const Eigen::Vector2d& p) const {
    return {kMargin + scale * (p.x() - area.low.x()), kTitle + scale * (area.high.y() - p.y())};
  }
  void set_color(const Color& color) {
    cairo_set_source_rgba(cairo.get(), color.r, color.g, color.b, color.alpha);
  }
  void clip_to_map() {
    const Eigen::Vector2d corner = to_pixel({area.low.x(), area.high.y()});
    cairo_rectangle(cairo.get(), corner.x(), corner.y(), scale * (area.high.x() - area.low.x()),
                    scale * (area.high.y() - area.low.y()));
    cairo_clip(cairo.get());
  }

  // Draws each cell as one pixel of an image, which is then scaled without smoothing.
  void draw_grid(const Grid& grid) {
    const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> image{
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, grid.width, grid.height),
        cairo_surface_destroy};
    cairo_surface_flush(image.get());
    unsigned char* const data = cairo_image_surface_get_data(image.get());
    if (data == nullptr) throw std::runtime_error("picture: the map has too many cells to draw");
    const int stride = cairo_image_surface_get_stride(image.get());
    for (int iy = 0; iy < grid.height; ++iy) {
      auto* const row = reinterpret_cast<std::uint32_t*>(
          data + static_cast<std::ptrdiff_t>(stride) * (grid.height - 1 - iy));
      for (int ix = 0; ix < grid.width; ++ix) row[ix] = to_rgb24(color_of(grid.at(ix, iy)));
    }
    cairo_surface_mark_dirty(image.get());
    cairo_save(cairo.get());
    clip_to_map();
    set_color(color_of(Cell::kUnknown));
    cairo_paint(cairo.get());
    const Area whole = grid_area(grid);
    const Eigen::Vector2d corner = to_pixel({whole.low.x(), whole.high.y()});
    cairo_translate(cairo.get(), corner.x(), corner.y());
    cairo_scale(cairo.get(), scale * grid.resolution, scale * grid.resolution);
    cairo_set_source_surface(cairo.get(), image.get(), 0.0, 0.0);
    cairo_pattern_set_filter(cairo_get_source(cairo.get()), CAIRO_FILTER_NEAREST);
    cairo_paint(cairo.get());
    cairo_restore(cairo.get());
  }

  // Fills and strokes the current path, clipped to the map, and adds the label to the legend.
  void finish(const Pen& pen) {
    cairo_path_t* const path = cairo_copy_path(cairo.get());
    cairo_new_path(cairo.get());
    cairo_save(cairo.get());
    clip_to_map();
    cairo_append_path(cairo.get(), path);
    cairo_path_destroy(path);
    apply(pen);
    cairo_restore(cairo.get());
    const auto same = [&](const Pen& other) { return other.label == pen.label; };
    if (!pen.label.empty() && std::none_of(legend.begin(), legend.end(), same))
      legend.push_back(pen);
  }
  void apply(const Pen& pen) {
    if (pen.fill) {
      set_color(*pen.fill);
      cairo_fill_preserve(cairo.get());
    }
    set_color(pen.color);
    cairo_set_line_width(cairo.get(), pen.width);
    cairo_set_dash(cairo.get(), &pen.dash, pen.dash > 0.0 ? 1 : 0, 0.0);
    cairo_stroke(cairo.get());
  }

  // Adds to the current path.
  void add_polyline(const std::vector<Eigen::Vector2d>& points, bool closed) {
    cairo_new_sub_path(cairo.get());
    for (const auto& p : points) {
      const Eigen::Vector2d pixel = to_pixel(p);
      cairo_line_to(cairo.get(), pixel.x(), pixel.y());
    }
    if (closed) cairo_close_path(cairo.get());
  }
  void draw_polyline(const std::vector<Eigen::Vector2d>& points, bool closed, const Pen& pen) {
    add_polyline(points, closed);
    finish(pen);
  }

  void write(const std::string& text, const Eigen::Vector2d& pixel, const Color& color) {
    cairo_move_to(cairo.get(), pixel.x(), pixel.y());
    cairo_text_path(cairo.get(), text.c_str());
    set_color(kPaper);
    cairo_set_line_width(cairo.get(), 4.0);
    cairo_set_dash(cairo.get(), nullptr, 0, 0.0);
    cairo_stroke_preserve(cairo.get());
    set_color(color);
    cairo_fill(cairo.get());
  }
  [[nodiscard]] double text_width(const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(cairo.get(), text.c_str(), &extents);
    return extents.x_advance;
  }

  // Draws the bar and its length at the lower left. Returns the x pixel where the text ends.
  double draw_scale_bar() {
    const double length = round_length(std::max(0.2 * (area.high.x() - area.low.x()), 1e-3));
    const double x = kMargin, y = height - 0.5 * kFooter, end = x + scale * length;
    for (const auto& [from, to] : {std::pair{Eigen::Vector2d{x, y}, Eigen::Vector2d{end, y}},
                                   {Eigen::Vector2d{x, y - 5}, Eigen::Vector2d{x, y + 5}},
                                   {Eigen::Vector2d{end, y - 5}, Eigen::Vector2d{end, y + 5}}}) {
      cairo_move_to(cairo.get(), from.x(), from.y());
      cairo_line_to(cairo.get(), to.x(), to.y());
      apply({kInk, 2.0});
    }
    const std::string text = metres(length);
    write(text, {end + 8.0, y + 5.0}, kInk);
    return end + 8.0 + text_width(text);
  }

  // Draws a sample and the label of each pen in the footer; omits those that do not fit.
  void draw_legend(double x) {
    const double y = height - 0.5 * kFooter;
    for (const Pen& pen : legend) {
      x += 26.0;
      if (x + 34.0 + text_width(pen.label) > width) return;
      if (pen.fill)
        cairo_rectangle(cairo.get(), x, y - 6.0, 26.0, 12.0);
      else {
        cairo_move_to(cairo.get(), x, y);
        cairo_line_to(cairo.get(), x + 26.0, y);
      }
      apply(pen);
      write(pen.label, {x + 34.0, y + 5.0}, kInk);
      x += 34.0 + text_width(pen.label);
    }
  }
};

}  // namespace tandem
