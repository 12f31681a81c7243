// SPDX-License-Identifier: Apache-2.0
// Fits the obstacle shapes around the robot on a background thread, ahead of where it drives, so
// that the node never waits for a fit.
#pragma once

#include <Eigen/Core>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "tandem/obstacle_extractor/extractor.hpp"

namespace tandem {

/// Shapes fitted beyond the published range, so that the robot can drive on while the next area is
/// fitted.
struct FittedArea {
  Eigen::Vector2d p_MC{0.0, 0.0};  ///< robot position at the request [m]
  std::vector<CoverShape> shapes;  ///< all within range + kAhead of p_MC
  double range = 0.0;              ///< [m]
};

/// An Extractor that runs on its own thread. Fitting a new area takes tenths of a second, but
/// `near` never waits for it: the fitted area extends kAhead beyond the range, and the next one is
/// requested once the robot has driven kRenew.
///
/// A map that changes with every scan is updated incrementally. Tiles with more than a few new
/// cells are refitted at once. Tiles whose shapes still cover all cells, but may no longer be the
/// best, are refitted one by one while no newer map is waiting.
class BackgroundExtractor {
 public:
  static constexpr double kAhead = 2.0;  ///< [m]
  static constexpr double kRenew = 0.5;  ///< [m]

  /// Throws std::invalid_argument on parameters out of their ranges.
  explicit BackgroundExtractor(const ExtractorParams& params);
  ~BackgroundExtractor();
  BackgroundExtractor(const BackgroundExtractor&) = delete;
  BackgroundExtractor& operator=(const BackgroundExtractor&) = delete;

  /// Refits with the new parameters; until that is done `near` returns the old shapes. Throws
  /// std::invalid_argument on parameters out of range and then changes nothing.
  void set_params(const ExtractorParams& params);

  /// The shapes of Extractor::near for this map, or for the previous map until this one is fitted.
  /// nullopt until the area around the point is fitted. Does not block.
  [[nodiscard]] std::optional<std::vector<Obstacle>> near(
      const std::shared_ptr<const StaticMap>& map, const Eigen::Vector2d& p_MB);

 private:
  struct Request {
    std::shared_ptr<const StaticMap> map;
    Eigen::Vector2d p_MC;
    std::shared_ptr<const ExtractorParams> params;
  };
  void run();

  std::shared_ptr<const ExtractorParams> params_;
  std::shared_ptr<const StaticMap> asked_map_;  // of the last request
  std::optional<Eigen::Vector2d> asked_p_MC_;

  std::mutex mutex_;
  std::condition_variable asked_;
  bool stop_ = false;
  std::optional<Request> waiting_;
  std::shared_ptr<const FittedArea> fitted_;

  std::thread worker_;
};

/// Shapes of the area within its range of the point; nullopt if the point is too far from the
/// area's centre for the result to be complete.
[[nodiscard]] std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                                 const Eigen::Vector2d& p_MB);

}  // namespace tandem
