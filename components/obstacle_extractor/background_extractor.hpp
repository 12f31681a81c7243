// SPDX-License-Identifier: Apache-2.0
// Fits the obstacle shapes around the robot in the background, ahead of where it drives, so that
// the node never waits for a fit.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
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

/// An Extractor whose fits are made by work(), on another thread than near(). Fitting a new area
/// takes tenths of a second, but `near` never waits for it: the fitted area extends kAhead beyond
/// the range, and the next one is requested once the robot has driven kRenew.
///
/// A map that changes with every scan is updated incrementally. Tiles with more than a few new
/// cells are refitted at once. Tiles whose shapes still cover all cells, but may no longer be the
/// best, are refitted one by one while no newer map is waiting.
class BackgroundExtractor {
 public:
  static constexpr double kAhead = 2.0;  ///< [m]
  static constexpr double kRenew = 0.5;  ///< [m]

  /// Makes the extractor of a map. It may have fitted some of the map for others already.
  using Make = std::function<std::shared_ptr<Extractor>(const std::shared_ptr<const StaticMap>&,
                                                        const ExtractorParams&)>;

  /// `wake` is called when there is work; it must not call work() itself. Throws
  /// std::invalid_argument on parameters out of their ranges.
  BackgroundExtractor(const ExtractorParams& params, std::function<void()> wake,
                      Make make = make_extractor);
  BackgroundExtractor(const BackgroundExtractor&) = delete;
  BackgroundExtractor& operator=(const BackgroundExtractor&) = delete;

  /// Refits with the new parameters; until that is done `near` returns the old shapes. Throws
  /// std::invalid_argument on parameters out of range and then changes nothing.
  void set_params(const ExtractorParams& params);

  /// The shapes of Extractor::near for this map, or for the previous map until this one is fitted.
  /// nullopt until the area around the point is fitted. Does not block.
  [[nodiscard]] std::optional<std::vector<Obstacle>> near(
      const std::shared_ptr<const StaticMap>& map, const Eigen::Vector2d& p_MB);

  /// Whether the shapes of `near` are those of this map already.
  [[nodiscard]] bool is_fitted(const std::shared_ptr<const StaticMap>& map);

  /// Does the next piece of work. Returns after how long [s] to call it again; nullopt: when it is
  /// woken. Only one thread may call it.
  [[nodiscard]] std::optional<double> work();

 private:
  struct Request {
    std::shared_ptr<const StaticMap> map;
    Eigen::Vector2d p_MC;
    std::shared_ptr<const ExtractorParams> params;
  };
  // What is left to do without a request: nothing; all stale tiles once no map has arrived for a
  // while; the tiles that are due; all stale tiles.
  enum class Rest { kNothing, kLater, kSome, kAll };
  [[nodiscard]] std::optional<double> pause() const;
  void begin(Request request);
  [[nodiscard]] bool refit();

  [[nodiscard]] static std::shared_ptr<Extractor> make_extractor(
      const std::shared_ptr<const StaticMap>& map, const ExtractorParams& params) {
    return std::make_shared<Extractor>(map, params);
  }

  std::function<void()> wake_;
  Make make_;
  std::shared_ptr<const ExtractorParams> params_;
  std::shared_ptr<const StaticMap> asked_map_;  // of the last request
  std::optional<Eigen::Vector2d> asked_p_MC_;

  std::mutex mutex_;
  std::optional<Request> waiting_;
  std::shared_ptr<const FittedArea> fitted_;
  std::shared_ptr<const StaticMap> fitted_map_;

  // Used by work() only:
  std::shared_ptr<Extractor> extractor_;
  std::optional<Request> request_;  // the last one
  Rest rest_ = Rest::kNothing;
};

/// Shapes of the area within its range of the point; nullopt if the point is too far from the
/// area's centre for the result to be complete.
[[nodiscard]] std::optional<std::vector<Obstacle>> shapes_within(const FittedArea& area,
                                                                 const Eigen::Vector2d& p_MB);

}  // namespace tandem
