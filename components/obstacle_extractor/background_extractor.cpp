// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/background_extractor.hpp"

#include <chrono>
#include <utility>

namespace tandem {
namespace {

using namespace std::chrono_literals;

constexpr long kSettle = 5;     // updates between two fits of a tile while maps keep arriving
constexpr auto kQuiet = 300ms;  // without a new map: the map is at rest

// Background work between two requests: none; wait for the map to come to rest; refit the tiles
// that are due; refit all stale tiles.
enum class Rest { kNothing, kLater, kSome, kAll };

}  // namespace

std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                   const Eigen::Vector2d& p_MB) {
  if (!((p_MB - area.p_MC).norm() <= BackgroundExtractor::kAhead)) return std::nullopt;
  std::vector<Obstacle> obstacles;
  for (const CoverShape& shape : area.shapes)
    if (distance_to_cells(shape, p_MB) <= area.range) obstacles.push_back(shape.obstacle);
  return obstacles;
}

BackgroundExtractor::BackgroundExtractor(const ExtractorParams& params) {
  set_params(params);
  worker_ = std::thread{[this] { run(); }};
}

void BackgroundExtractor::set_params(const ExtractorParams& params) {
  check(params);
  params_ = std::make_shared<const ExtractorParams>(params);
  asked_p_MC_.reset();
}

BackgroundExtractor::~BackgroundExtractor() {
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  asked_.notify_one();
  worker_.join();
}

std::optional<std::vector<Obstacle>> BackgroundExtractor::near(
    const std::shared_ptr<const StaticMap>& map, const Eigen::Vector2d& p_MB) {
  if (!map || !p_MB.allFinite()) return std::nullopt;
  const bool asks = map != asked_map_ || !asked_p_MC_ || (p_MB - *asked_p_MC_).norm() >= kRenew;
  std::shared_ptr<const FittedArea> area;
  {
    const std::lock_guard lock{mutex_};
    if (asks || waiting_) waiting_ = Request{map, p_MB, params_};  // newest position
    area = fitted_;
  }
  if (asks) {
    asked_map_ = map;
    asked_p_MC_ = p_MB;
    asked_.notify_one();
  }
  return area ? shapes_within(*area, p_MB) : std::nullopt;
}

void BackgroundExtractor::run() {
  std::shared_ptr<const StaticMap> map;
  std::shared_ptr<const ExtractorParams> params;
  std::optional<Extractor> extractor;
  Eigen::Vector2d p_MC{0.0, 0.0};
  Rest rest = Rest::kNothing;
  std::unique_lock lock{mutex_};
  while (true) {
    const auto is_asked = [&] { return stop_ || waiting_; };
    if (rest == Rest::kNothing)
      asked_.wait(lock, is_asked);
    else if (rest == Rest::kLater && !asked_.wait_for(lock, kQuiet, is_asked))
      rest = Rest::kAll;
    if (stop_) return;
    const auto request = std::exchange(waiting_, std::nullopt);
    lock.unlock();
    bool has_changed = true;
    if (request) {
      p_MC = request->p_MC;
      if (!extractor || request->params != params)
        extractor.emplace(request->map, *request->params);
      else if (request->map != map)
        extractor->update(request->map);
      map = request->map;
      params = request->params;
      rest = Rest::kSome;
    } else {
      has_changed =
          extractor->refresh_near(p_MC, params->range + kAhead, rest == Rest::kAll ? 0 : kSettle);
      if (!has_changed) rest = rest == Rest::kAll ? Rest::kNothing : Rest::kLater;
    }
    std::shared_ptr<const FittedArea> area;
    if (has_changed)
      area = std::make_shared<const FittedArea>(
          FittedArea{p_MC, extractor->shapes_near(p_MC, params->range + kAhead), params->range});
    lock.lock();
    if (area) fitted_ = std::move(area);
  }
}

}  // namespace tandem
