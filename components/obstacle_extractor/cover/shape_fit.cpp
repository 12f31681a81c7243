// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/shape_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace tandem {
namespace {

constexpr double kRoom = 1.0 + 1e-9;  // margin so that rounding leaves no point outside

Obstacle circle_around(const Points& hull) {
  const Circle circle = smallest_circle(hull);
  Obstacle shape;
  shape.p_MO = circle.p_MC;
  for (const auto& p : hull) shape.a = std::max(shape.a, kRoom * (p - circle.p_MC).norm());
  shape.b = shape.a;
  return shape;
}

Obstacle rectangle_of(const TurnedBox& box) {
  const bool is_long = box.half.x() >= box.half.y();
  Obstacle shape;
  shape.shape = ObstacleShape::kRectangle;
  shape.p_MO = box.p_MC;
  shape.angle = is_long ? box.angle : box.angle + 0.5 * std::numbers::pi;
  shape.a = kRoom * box.half.maxCoeff();
  shape.b = kRoom * box.half.minCoeff();
  return shape;
}

// Parameters of (1): the length lies along the box.
struct Form {
  TurnedBox box;
  double b, shift;  // [m]
};

struct Candidate {
  Obstacle shape;
  double price;
  std::optional<Form> form;  // nullopt: the circle or the rectangle
};

// The ellipse of (1), or a circle of radius b if the ellipse would be shorter than wide.
Obstacle ellipse_of_width(const Points& hull, const TurnedBox& box, double b, double shift) {
  const Eigen::Vector2d &along = box.along, across{-along.y(), along.x()};
  Obstacle ellipse;
  ellipse.p_MO = box.p_MC + shift * across;
  ellipse.angle = box.angle;
  double most = 0.0;  // of x² / (1 − ((y − s) / b)²)
  for (const auto& p : hull) {
    const Eigen::Vector2d d = p - ellipse.p_MO;
    const double x = along.dot(d), y = across.dot(d) / b;
    most = std::max(most, x * x / (1.0 - y * y));
  }
  ellipse.a = kRoom * std::max(std::sqrt(most), b);
  ellipse.b = kRoom * b;
  return ellipse;
}

// Whether all points on the outline of an ellipse with the shape's centre and heading are allowed.
bool is_within_along(const Obstacle& shape, const Eigen::Vector2d& half, const FreeSpace& space,
                     const Excess& most) {
  constexpr double kSpacing = 0.04;  // [m]
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  const int points = std::max(16, static_cast<int>(4.0 * half.sum() / kSpacing));
  const double step = 2.0 * std::numbers::pi / points;
  const double cos_step = std::cos(step), sin_step = std::sin(step);
  double x = 1.0, y = 0.0;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector2d q{half.x() * x, half.y() * y};
    const Eigen::Vector2d turned_q{c * q.x() - s * q.y(), s * q.x() + c * q.y()};
    if (!space.allows(shape.p_MO + turned_q, most)) return false;
    const double turned = cos_step * x - sin_step * y;
    y = sin_step * x + cos_step * y;
    x = turned;
  }
  return true;
}

// Whether all points of a lattice over the rectangle are allowed.
bool is_rectangle_within(const Obstacle& shape, const FreeSpace& space, const Excess& most) {
  constexpr double kSpacing = 0.04;  // [m]
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  const Eigen::Vector2d reach{std::abs(c) * shape.a + std::abs(s) * shape.b,
                              std::abs(s) * shape.a + std::abs(c) * shape.b};
  if (!space.is_known(shape.p_MO - reach, shape.p_MO + reach)) return false;
  const int columns = static_cast<int>(std::ceil(2.0 * shape.a / kSpacing));
  const int rows = static_cast<int>(std::ceil(2.0 * shape.b / kSpacing));
  for (int i = 0; i <= columns; ++i)
    for (int k = 0; k <= rows; ++k) {
      const Eigen::Vector2d q{shape.a * (2.0 * i / columns - 1.0),
                              shape.b * (2.0 * k / rows - 1.0)};
      const Eigen::Vector2d turned_q{c * q.x() - s * q.y(), s * q.x() + c * q.y()};
      if (!space.allows(shape.p_MO + turned_q, most)) return false;
    }
  return true;
}

// Whether the shape reaches no deeper into free space than `most`. Tests an ellipse's outline,
// smaller copies of it inside, and the long axis where the copies are far apart. False if the shape
// leaves the known window.
bool is_within(const Obstacle& shape, const FreeSpace& space, const Excess& most) {
  if (is_rectangle(shape)) return is_rectangle_within(shape, space, most);
  constexpr double kRing = 0.07;  // [m] between two copies along the short axis
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  const Eigen::Vector2d reach{std::hypot(c * shape.a, s * shape.b),
                              std::hypot(s * shape.a, c * shape.b)};
  if (!space.is_known(shape.p_MO - reach, shape.p_MO + reach)) return false;
  const Eigen::Vector2d half{shape.a, shape.b};
  const int rings = std::max(1, static_cast<int>(std::ceil(shape.b / kRing)));
  for (int ring = rings; ring > 0; --ring)
    if (!is_within_along(shape, half * ring / rings, space, most)) return false;
  return is_within_along(shape, {shape.a, 0.0}, space, most);
}

// Searches the ellipses around one hull.
class Search {
 public:
  Search(const Points& hull, const FreeSpace& space, const FitLimits& limits)
      : hull_{hull}, space_{space}, limits_{limits} {}

  // Free space taken minus the bonus; exact only up to `most`. `along`: unit vector of the length.
  [[nodiscard]] double price(const Obstacle& shape, const Eigen::Vector2d& along,
                             double most) const {
    return space_.taken_by(shape, along, most + bonus(shape)) - bonus(shape);
  }
  [[nodiscard]] double bonus(const Obstacle& shape) const {
    return is_circle(shape) ? limits_.circle_bonus : 0.0;
  }
  [[nodiscard]] bool is_allowed(const Obstacle& shape) const {
    return is_within(shape, space_, limits_.excess);
  }
  [[nodiscard]] Obstacle ellipse(const Form& form) const {
    return ellipse_of_width(hull_, form.box, form.b, form.shift);
  }

  // The cheapest of circle, rectangle and a coarse grid of ellipses; nullopt if none is allowed.
  [[nodiscard]] std::optional<Candidate> coarse(const TurnedBox& box,
                                                const Obstacle& circle) const {
    std::vector<Candidate> candidates;
    const auto add = [&](const Obstacle& shape, const std::optional<Form>& form) {
      if (const double paid = price(shape, box.along, limits_.price); paid <= limits_.price)
        candidates.push_back({shape, paid, form});
    };
    add(circle, std::nullopt);
    add(rectangle_of(box), std::nullopt);
    if (const auto good = cheapest(candidates); good && good->price <= kCheap) return good;
    for (const double shift : {0.0, 1.0, -1.0, 3.0, -3.0})
      for (const double bulge : {0.01, 0.025, 0.05, 0.1, 0.2}) {
        const Form form{box, box.half.y() + std::abs(shift * bulge) + bulge, shift * bulge};
        add(ellipse(form), form);
      }
    return cheapest(candidates);
  }

  // Pattern search over heading, width and shift; the steps shrink when none is better.
  [[nodiscard]] Candidate improved(Candidate best) const {
    double turn = kTurn, step = kStep;
    for (int round = 0; round < kRounds && best.price > kCheap; ++round) {
      bool is_better = false;
      for (const Change& change : kChanges) {
        Form form = *best.form;
        if (change.turn != 0.0) form.box = box_along(hull_, form.box.angle + change.turn * turn);
        form.b += change.b * step;
        form.shift += change.shift * step;
        if (form.b < form.box.half.y() + std::abs(form.shift) + kLeastBulge) continue;
        const Obstacle shape = ellipse(form);
        const double paid = price(shape, form.box.along, best.price - kLeastGain);
        if (paid > best.price - kLeastGain || !is_allowed(shape)) continue;
        best = {shape, paid, form};
        is_better = true;
      }
      if (is_better) continue;
      turn *= 0.5;
      step *= 0.5;
    }
    return best;
  }

 private:
  // The cheapest that is allowed. Sorts the candidates.
  [[nodiscard]] std::optional<Candidate> cheapest(std::vector<Candidate>& candidates) const {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.price < b.price; });
    for (const Candidate& candidate : candidates)
      if (is_allowed(candidate.shape)) return candidate;
    return std::nullopt;
  }

  struct Change {
    double turn, b, shift;
  };
  static constexpr std::array<Change, 8> kChanges{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 1, 1}, {0, 1, -1}}};
  static constexpr double kTurn = 0.08;  // [rad] first step
  static constexpr double kStep = 0.03;  // [m]
  static constexpr int kRounds = 8;
  static constexpr double kCheap = 1e-3;        // [m²] good enough: the search stops
  static constexpr double kLeastGain = 1e-4;    // [m²]
  static constexpr double kLeastBulge = 0.004;  // [m] smaller values make (1) badly conditioned

  const Points& hull_;
  const FreeSpace& space_;
  const FitLimits& limits_;
};

}  // namespace

ShapeFit fit_shape(const Points& hull, const FreeSpace& space, const FitLimits& limits) {
  const Search search(hull, space, limits);
  const TurnedBox box = smallest_box(hull);
  const Obstacle circle = circle_around(hull);
  const auto found = search.coarse(box, circle);
  if (!found) return {circle, space.taken_by(circle), false, box.angle, 0.0};
  const Candidate best = found->form ? search.improved(*found) : *found;
  return {best.shape, best.price + search.bonus(best.shape), true, box.angle, found->price};
}

}  // namespace tandem
