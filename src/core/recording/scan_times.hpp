// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The scans of a view's moment.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"

namespace cloud_colorizer {

/// The scans nearest in time to a moment.
class ScanTimes {
 public:
  explicit ScanTimes(const std::vector<Scan>& scans);
  /// Indices of the last one before and the first one after, if they are near enough in time.
  std::vector<std::size_t> around(double stamp) const;

 private:
  std::vector<std::pair<double, std::size_t>> times_;  ///< ascending
};

/// What the scans around a moment tell a camera at a pose; null where there are none. `ranges`: scanRanges() of a scan.
std::shared_ptr<const EmptySpace> emptySpaceAt(
    const Recording& recording, const ScanTimes& times, double stamp, const Eigen::Isometry3d& map_from_camera,
    const std::function<std::shared_ptr<const ScanRanges>(std::size_t scan)>& ranges);

}  // namespace cloud_colorizer
