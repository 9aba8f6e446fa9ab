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

/// What a scan tells: the nearest range of every cell, and up to where it is empty.
struct ScanRanges {
  cv::Mat1w measured, empty;
};
inline ScanRanges scanRanges(const cv::Mat1w& panorama) {
  return {panorama, emptyRanges(panorama)};
}

/// Which space in front of a camera was empty.
class EmptySpace {
 public:
  /// `ranges`: of emptyRanges(); `measured`: the panorama that they come from, or null.
  void add(std::shared_ptr<const cv::Mat1w> ranges, const Eigen::Isometry3f& sensor_from_camera,
           std::shared_ptr<const cv::Mat1w> measured = nullptr);

  /// Whether a scan saw through the place [m, in the camera's frame], and no other has it that something was there.
  bool contains(const Eigen::Vector3f& point) const;
  /// Whether a scan measured the surface at `point` [m, in the camera's frame] and looked through what seems to hide it
  /// at `distance` [m] from the camera, and no other scan has it otherwise. `tolerance`: m of range that measurements
  /// may differ by; `tangent`: of the angle of incidence, as a cell of a scan has the nearest of a slanted surface.
  bool uncovers(const Eigen::Vector3f& point, float distance, float tolerance, float tangent) const;
  bool knowsNothing() const { return scans_.empty(); }
  std::size_t numBytes() const;

 private:
  struct Ranges {
    std::shared_ptr<const cv::Mat1w> ranges, measured;
    Eigen::Matrix3f rotation;
    Eigen::Vector3f translation;

    /// m, the nearest range in the direction of a place in the sensor's frame; 0 where the cell has none.
    float measuredAt(const Eigen::Vector3f& place) const;
  };
  std::vector<Ranges> scans_;
};

}  // namespace cloud_colorizer
