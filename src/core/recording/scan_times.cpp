// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/scan_times.hpp"

#include <algorithm>
#include <iterator>

namespace cloud_colorizer {

namespace {

constexpr double kMaxAge = 0.25;  // s; a scan tells nothing of moments farther from it

}  // namespace

ScanTimes::ScanTimes(const std::vector<Scan>& scans) {
  for (std::size_t i = 0; i < scans.size(); ++i) times_.emplace_back(scans[i].stamp, i);
  std::sort(times_.begin(), times_.end());
}

std::vector<std::size_t> ScanTimes::around(double stamp) const {
  const auto after = std::lower_bound(times_.begin(), times_.end(), std::make_pair(stamp, std::size_t{0}));
  std::vector<std::size_t> indices;
  if (after != times_.begin() && stamp - std::prev(after)->first <= kMaxAge)
    indices.push_back(std::prev(after)->second);
  if (after != times_.end() && after->first - stamp <= kMaxAge) indices.push_back(after->second);
  return indices;
}

std::shared_ptr<const EmptySpace> emptySpaceAt(
    const Recording& recording, const ScanTimes& times, double stamp, const Eigen::Isometry3d& map_from_camera,
    const std::function<std::shared_ptr<const ScanRanges>(std::size_t)>& ranges) {
  EmptySpace space;
  for (const std::size_t scan : times.around(stamp)) {
    const Eigen::Isometry3d sensor_from_camera = recording.scans()[scan].map_from_sensor.inverse() * map_from_camera;
    space.add({ranges(scan), sensor_from_camera.cast<float>()});
  }
  return space.knowsNothing() ? nullptr : std::make_shared<const EmptySpace>(std::move(space));
}

}  // namespace cloud_colorizer
