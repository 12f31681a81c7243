// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/shapes_ahead.hpp"

#include <utility>

namespace tandem {

std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                   const Eigen::Vector2d& p_MB, double range) {
  if (!((p_MB - area.p_MC).norm() <= ShapesAhead::kAhead)) return std::nullopt;
  std::vector<Obstacle> obstacles;
  for (const CoverShape& shape : area.shapes)
    if (distance_to_cells(shape, p_MB) <= range) obstacles.push_back(shape.obstacle);
  return obstacles;
}

ShapesAhead::ShapesAhead(const ExtractorParams& params) : params_{params} {
  check(params);
  worker_ = std::thread{[this] { run(); }};
}

ShapesAhead::~ShapesAhead() {
  {
    const std::lock_guard lock{mutex_};
    stop_ = true;
  }
  asked_.notify_one();
  worker_.join();
}

std::optional<std::vector<Obstacle>> ShapesAhead::near(const std::shared_ptr<const StaticMap>& map,
                                                       const Eigen::Vector2d& p_MB) {
  if (!map || !p_MB.allFinite()) return std::nullopt;
  const bool asks = map != asked_map_ || !asked_p_MC_ || (p_MB - *asked_p_MC_).norm() >= kRenew;
  std::shared_ptr<const FittedArea> area;
  {
    const std::lock_guard lock{mutex_};
    if (asks || waiting_) waiting_ = Request{map, p_MB};  // the newest place
    area = fitted_;
  }
  if (asks) {
    asked_map_ = map;
    asked_p_MC_ = p_MB;
    asked_.notify_one();
  }
  return area ? shapes_within(*area, p_MB, params_.range) : std::nullopt;
}

void ShapesAhead::run() {
  std::shared_ptr<const StaticMap> map;
  std::optional<Extractor> extractor;
  std::unique_lock lock{mutex_};
  while (true) {
    asked_.wait(lock, [this] { return stop_ || waiting_; });
    if (stop_) return;
    const Request request = std::move(*waiting_);
    waiting_.reset();
    lock.unlock();
    if (request.map != map) extractor.emplace(map = request.map, params_);
    auto area = std::make_shared<const FittedArea>(
        FittedArea{request.p_MC, extractor->shapes_near(request.p_MC, params_.range + kAhead)});
    lock.lock();
    fitted_ = std::move(area);
  }
}

}  // namespace tandem
