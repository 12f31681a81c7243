// SPDX-License-Identifier: Apache-2.0
// In: scans of one sensor. Out: what each of them says, and what is wrong with the driver.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/octomap_builder/own_body.hpp"

namespace tandem {

struct ScanReaderParams {
  // Without a list in braces, at which GCC 12 fails in structs that hold this one.
  std::vector<std::string> no_return = std::vector<std::string>(1, "inf");

  template <class Visitor>
  void visit(Visitor&& field) {
    field("no_return", no_return, OneOf{kNoReturnNames},
          "what the driver sends where nothing is in range; anything else up to range_max is an "
          "echo, and what is NaN, 0 or beyond range_max says nothing");
  }
};

/// What a scan says as a whole.
struct ScanReading {
  std::string error;          ///< why it cannot be read, in one line; empty if it can
  RangeReturns seen;          ///< in the sensor's frame, without those of the robot itself
  std::size_t own_body = 0;   ///< echoes that are of the robot itself
  double valid_share = 0.0;   ///< of all beams: echoes that are not too near, and free ways
  std::string composition{};  ///< what the beams are, for people: "360 beams: 300 nan, 60 in range"
};

/// Reads the scans of one sensor and remembers what its driver does from scan to scan.
class ScanReader {
 public:
  /// `min_range` [m]: echoes that are nearer are not used.
  ScanReader(const ScanReaderParams& params, double min_range);

  /// Of a sensor at X_BS. With `range_max` in no_return a range_max that has changed since the
  /// first scan is an error: such a driver sends its farthest echo, which is no free way.
  [[nodiscard]] ScanReading read(const RangeScan& scan, const Eigen::Isometry3d& X_BS,
                                 const OwnBody& body);

  /// The name that no_return seems to lack: of the last 20 scans more than half of the beams were
  /// this value. Told once for each name.
  [[nodiscard]] std::optional<std::string> missing_name(const RangeScan& scan);

  /// Takes the next range_max for the driver's own.
  void forget() { range_max_.reset(), varies_ = false; }

  [[nodiscard]] const NoReturn& no_return() const { return no_return_; }

 private:
  [[nodiscard]] std::string range_max_error(const RangeScan& scan);

  NoReturn no_return_;
  double min_range_;
  std::optional<double> range_max_;  // of the first scan [m]
  bool varies_ = false;
  std::string most_;       // what most beams of the last scan were
  int scans_of_most_ = 0;  // in a row
  std::vector<std::string> told_;
};

}  // namespace tandem
