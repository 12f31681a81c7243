// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/people.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>

namespace tandem {
namespace {

constexpr std::uint32_t kFirstId = 0xFFFF0000;  // practically never the id of a static obstacle
constexpr int kMaxDraws = 100;

// Desired velocity of a walker at p_MP.
Eigen::Vector2d wanted(const Walker& walker, const Eigen::Vector2d& p_MP, std::size_t next) {
  const Eigen::Vector2d to = walker.p_MW[next] - p_MP;
  const double distance = to.norm();
  if (walker.p_MW.size() < 2 || distance <= 0.0) return Eigen::Vector2d::Zero();
  return walker.speed / distance * to;
}

}  // namespace

std::vector<double> to_numbers(std::span<const Walker> walkers) {
  std::vector<double> numbers;
  for (const Walker& walker : walkers) {
    numbers.insert(numbers.end(),
                   {walker.radius, walker.speed, static_cast<double>(walker.p_MW.size())});
    for (const auto& p : walker.p_MW) numbers.insert(numbers.end(), {p.x(), p.y()});
  }
  return numbers;
}

std::vector<Walker> walkers_of(std::span<const double> numbers) {
  std::vector<Walker> walkers;
  for (std::size_t i = 0; i < numbers.size();) {
    const auto rest = static_cast<double>(numbers.size() - i);
    if (rest < 5.0 || !(numbers[i + 2] >= 1.0 && 3.0 + 2.0 * numbers[i + 2] <= rest) ||
        numbers[i + 2] != std::floor(numbers[i + 2]))
      throw std::invalid_argument(
          "people: each needs radius, speed, number of points, x1, y1, … of the path");
    Walker walker{numbers[i], numbers[i + 1], {}};
    if (!(walker.radius > 0.0 && walker.speed >= 0.0))
      throw std::invalid_argument(
          "people: a radius must be positive and a speed must not be negative");
    const std::size_t end = i + 3 + 2 * static_cast<std::size_t>(numbers[i + 2]);
    for (i += 3; i < end; i += 2) walker.p_MW.emplace_back(numbers[i], numbers[i + 1]);
    walkers.push_back(std::move(walker));
  }
  return walkers;
}

std::vector<Walker> crossing_people(const Crossings& crossings, unsigned seed,
                                    const Eigen::Vector2d& p_MB) {
  std::mt19937 random{seed};
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
  };
  std::vector<Walker> walkers;
  for (int i = 0; i < crossings.count; ++i) {
    Walker walker{crossings.radius, between(crossings.slowest, crossings.fastest), {}};
    for (int draw = 0; draw < kMaxDraws; ++draw) {
      const auto& low = crossings.low;
      const auto& high = crossings.high;
      Eigen::Vector2d from{low.x(), between(low.y(), high.y())};
      Eigen::Vector2d to{high.x(), between(low.y(), high.y())};
      if (random() % 2 == 0) {
        from = {between(low.x(), high.x()), low.y()};
        to = {between(low.x(), high.x()), high.y()};
      }
      if (random() % 2 == 0) std::swap(from, to);
      walker.p_MW = {from, to};
      if ((from - p_MB).norm() > kStartGap) break;
    }
    walkers.push_back(std::move(walker));
  }
  return walkers;
}

People::People(std::vector<Walker> walkers, double acceleration)
    : walkers_{std::move(walkers)}, acceleration_{acceleration} {
  restart();
}

void People::restart() {
  all_.clear();
  headings_.assign(walkers_.size(), {});
  for (std::size_t i = 0; i < walkers_.size(); ++i) {
    const Walker& walker = walkers_[i];
    Obstacle person{.id = kFirstId + static_cast<std::uint32_t>(i),
                    .p_MO = walker.p_MW.front(),
                    .a = walker.radius,
                    .b = walker.radius};
    all_.push_back(person);
    turn_to_next(i);
    all_[i].v_MO = wanted(walker, person.p_MO, headings_[i].next);
  }
}

void People::send(std::size_t i, std::vector<Eigen::Vector2d> p_MW) {
  walkers_[i].p_MW = std::move(p_MW);
  headings_[i] = {};
}

double People::cast_ray(const Eigen::Vector2d& p_MQ, double heading, double max_range) const {
  const Eigen::Vector2d ahead{std::cos(heading), std::sin(heading)};
  double nearest = max_range;
  for (const Obstacle& person : all_) {
    const Eigen::Vector2d to = person.p_MO - p_MQ;
    const double along = ahead.dot(to), radius = person.a;
    const double half_chord = radius * radius - (to.squaredNorm() - along * along);  // squared
    const bool is_within = to.squaredNorm() <= radius * radius;
    if (half_chord < 0.0 || (along < 0.0 && !is_within)) continue;
    nearest = std::min(nearest, is_within ? 0.0 : along - std::sqrt(half_chord));
  }
  return nearest;
}

void People::advance(double dt) {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    Obstacle& person = all_[i];
    const Walker& walker = walkers_[i];
    if ((walker.p_MW[headings_[i].next] - person.p_MO).norm() < kArrived) turn_to_next(i);
    const Eigen::Vector2d change = wanted(walker, person.p_MO, headings_[i].next) - person.v_MO;
    const double most = acceleration_ * dt;
    const Eigen::Vector2d before = person.v_MO;
    person.v_MO += change.norm() > most ? Eigen::Vector2d(most * change.normalized()) : change;
    person.p_MO += 0.5 * dt * (before + person.v_MO);
  }
}

void People::turn_to_next(std::size_t i) {
  auto& [next, back] = headings_[i];
  const std::size_t last = walkers_[i].p_MW.size() - 1;
  if (last == 0) return;
  if (next == (back ? 0 : last)) back = !back;
  next = back ? next - 1 : next + 1;
}

}  // namespace tandem
