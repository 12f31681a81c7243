// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/background_extractor.hpp"

#include <utility>

namespace tandem {
namespace {

constexpr long kSettle = 5;     // updates between two fits of a tile while maps keep arriving
constexpr double kQuiet = 0.3;  // [s] without a new map: the map is at rest

}  // namespace

std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                   const Eigen::Vector2d& p_MB) {
  if (!((p_MB - area.p_MC).norm() <= BackgroundExtractor::kAhead)) return std::nullopt;
  std::vector<Obstacle> obstacles;
  for (const CoverShape& shape : area.shapes)
    if (distance_to_cells(shape, p_MB) <= area.range) obstacles.push_back(shape.obstacle);
  return obstacles;
}

BackgroundExtractor::BackgroundExtractor(const ExtractorParams& params, std::function<void()> wake,
                                         Make make)
    : wake_{std::move(wake)}, make_{std::move(make)} {
  set_params(params);
}

void BackgroundExtractor::set_params(const ExtractorParams& params) {
  check(params);
  params_ = std::make_shared<const ExtractorParams>(params);
  asked_p_MC_.reset();
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
    wake_();
  }
  return area ? shapes_within(*area, p_MB) : std::nullopt;
}

bool BackgroundExtractor::is_fitted(const std::shared_ptr<const StaticMap>& map) {
  const std::lock_guard lock{mutex_};
  return map && map == fitted_map_;
}

std::optional<double> BackgroundExtractor::work() {
  std::unique_lock lock{mutex_};
  auto request = std::exchange(waiting_, std::nullopt);
  lock.unlock();
  if (!request && rest_ == Rest::kNothing) return std::nullopt;
  if (!request && rest_ == Rest::kLater) rest_ = Rest::kAll;
  bool has_changed = true;
  if (request)
    begin(*std::move(request));
  else
    has_changed = refit();
  if (has_changed) {
    const double reach = request_->params->range + kAhead;
    auto area = std::make_shared<const FittedArea>(FittedArea{
        request_->p_MC, extractor_->shapes_near(request_->p_MC, reach), request_->params->range});
    lock.lock();
    fitted_ = std::move(area);
    fitted_map_ = request_->map;
  }
  return pause();
}

std::optional<double> BackgroundExtractor::pause() const {
  if (rest_ == Rest::kNothing) return std::nullopt;
  return rest_ == Rest::kLater ? kQuiet : 0.0;
}

void BackgroundExtractor::begin(Request request) {
  if (!extractor_ || request.params != request_->params) {
    extractor_ = make_(request.map, *request.params);
    extractor_->put_down();
  } else if (request.map != request_->map) {
    if (extractor_.use_count() > 1)  // others go on with the old map
      extractor_ = std::make_shared<Extractor>(*extractor_);
    extractor_->update(request.map);
  }
  request_ = std::move(request);
  rest_ = Rest::kSome;
}

// Returns whether a tile was refitted.
bool BackgroundExtractor::refit() {
  const double reach = request_->params->range + kAhead;
  if (extractor_->refresh_near(request_->p_MC, reach, rest_ == Rest::kAll ? 0 : kSettle))
    return true;
  rest_ = rest_ == Rest::kAll ? Rest::kNothing : Rest::kLater;
  return false;
}

}  // namespace tandem
