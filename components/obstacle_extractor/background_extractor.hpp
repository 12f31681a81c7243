// SPDX-License-Identifier: Apache-2.0
// In: maps, and where the robot is. Out: the shapes near it, fitted ahead by a thread.
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

/// Shapes farther than a list reaches, so that the robot can drive on while the next is fitted.
struct FittedArea {
  Eigen::Vector2d p_MC{0.0, 0.0};  ///< where the robot was [m]
  std::vector<CoverShape> shapes;  ///< all within range + kAhead of it
  double range = 0.0;              ///< [m]
};

/// An extractor on a thread of its own. A first look at a place costs tenths of a second; `near`
/// never waits for it, because everything within kAhead beyond the range is there before the robot
/// is, and the next is fitted once the robot has driven kRenew.
///
/// A map that changes with every scan is followed by what changed in it: at once the tiles that
/// show more than a few new cells, then, one by one while no newer map waits, those whose shapes
/// cover all but could be better.
class BackgroundExtractor {
 public:
  static constexpr double kAhead = 2.0;  ///< [m]
  static constexpr double kRenew = 0.5;  ///< [m]

  /// Throws std::invalid_argument on parameters out of their ranges.
  explicit BackgroundExtractor(const ExtractorParams& params);
  ~BackgroundExtractor();
  BackgroundExtractor(const BackgroundExtractor&) = delete;
  BackgroundExtractor& operator=(const BackgroundExtractor&) = delete;

  /// Fits anew; until that is done `near` goes on as before. Throws std::invalid_argument, having
  /// changed nothing, on parameters out of range.
  void set_params(const ExtractorParams& params);

  /// The same shapes as Extractor::near, of this map or, until it is fitted, of the one before.
  /// nullopt while the place is not fitted yet. Does not wait.
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
  std::shared_ptr<const StaticMap> asked_map_;  // the last request's
  std::optional<Eigen::Vector2d> asked_p_MC_;

  std::mutex mutex_;
  std::condition_variable asked_;
  bool stop_ = false;
  std::optional<Request> waiting_;
  std::shared_ptr<const FittedArea> fitted_;

  std::thread worker_;
};

/// Shapes of the area near a point within it; nullopt if the area may miss some of them.
[[nodiscard]] std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                                 const Eigen::Vector2d& p_MB);

}  // namespace tandem
