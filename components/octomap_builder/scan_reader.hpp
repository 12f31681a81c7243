// SPDX-License-Identifier: Apache-2.0
// Reads the scans of one sensor and detects misconfigured drivers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/octomap_builder/own_body.hpp"

namespace tandem {

/// How a scanner reports that nothing is in range.
struct ScanReaderParams {
  // Not a braced list: GCC 12 rejects that in structs that contain this one.
  std::vector<std::string> no_return = std::vector<std::string>(1, "inf");

  template <class Visitor>
  void visit(Visitor&& field) {
    field("no_return", no_return, OneOf{kNoReturnNames},
          "what the driver sends when nothing is in range; any other value up to range_max is a "
          "return, and NaN, 0 and values beyond range_max carry no information");
  }
};

/// Result of reading one scan.
struct ScanReading {
  std::string error;          ///< why it cannot be read, in one line; empty if it can
  RangeReturns seen;          ///< in the sensor's frame, without the robot's own body
  std::size_t own_body = 0;   ///< number of returns from the robot's own body
  double valid_share = 0.0;   ///< share of the beams that are returns beyond min_range or free
  std::string composition{};  ///< summary for log lines: "360 beams: 300 nan, 60 in range"
};

/// Reads the scans of one sensor and tracks its driver's behaviour from scan to scan.
class ScanReader {
 public:
  /// `min_range` [m]: nearer returns are not used.
  ScanReader(const ScanReaderParams& params, double min_range);

  /// Reads a scan of a sensor at X_BS. If no_return contains `range_max`, a range_max that differs
  /// from the first scan's is an error: such a driver puts its farthest return there, and that is
  /// not free space.
  [[nodiscard]] ScanReading read(const RangeScan& scan, const Eigen::Isometry3d& X_BS,
                                 const OwnBody& body);

  /// The name that is probably missing in no_return: in each of the last 20 scans more than half of
  /// the beams had this value. Each name is returned only once.
  [[nodiscard]] std::optional<std::string> missing_name(const RangeScan& scan);

  /// Forgets the first range_max; the next scan's counts as the first.
  void forget() { range_max_.reset(), varies_ = false; }

  /// The values that mean "nothing in range".
  [[nodiscard]] const NoReturn& no_return() const { return no_return_; }

 private:
  [[nodiscard]] std::string range_max_error(const RangeScan& scan);

  NoReturn no_return_;
  double min_range_;
  std::optional<double> range_max_;  // of the first scan [m]
  bool varies_ = false;
  std::string most_;       // the kind of most beams in the last scan
  int scans_of_most_ = 0;  // in a row
  std::vector<std::string> told_;
};

}  // namespace tandem
