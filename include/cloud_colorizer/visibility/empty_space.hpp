// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scans: which space a range sensor saw to be empty at the moment of a view. A map holds everything that ever was
/// measured, also the trail of a van; what the scan of that moment saw through was not there.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace cloud_colorizer {

/// The nearest range in every direction: 16 bit, 256 steps a metre, 0 where nothing was measured. Columns: azimuth
/// about z, from -180 to 180 deg; rows: sine of the elevation, from 1 to -1; so all cells span the same solid angle.
/// `positions` [m] in the sensor's frame; those that are not finite or nearer than `min_range` are left out.
/// `resolution`: deg that a cell spans at the horizon.
cv::Mat1w makeRangePanorama(const Eigen::Matrix3Xd& positions, double resolution, double min_range);

/// The range up to which a scan tells that space was empty, in the same cells: that of the nearest return in a cell and
/// those beside it, less a margin for noise. 0 where the cell has no return: nothing is known there.
cv::Mat1w emptyRanges(const cv::Mat1w& panorama);

/// Which space in front of a camera was empty.
class EmptySpace {
 public:
  /// `ranges`: of emptyRanges().
  void add(std::shared_ptr<const cv::Mat1w> ranges, const Eigen::Isometry3f& sensor_from_camera);

  /// Whether a scan saw through the place [m, in the camera's frame], and no other has it that something was there.
  bool contains(const Eigen::Vector3f& point) const;
  bool knowsNothing() const { return scans_.empty(); }
  std::size_t numBytes() const;

 private:
  struct Ranges {
    std::shared_ptr<const cv::Mat1w> ranges;
    Eigen::Matrix3f rotation;
    Eigen::Vector3f translation;
  };
  std::vector<Ranges> scans_;
};

}  // namespace cloud_colorizer
