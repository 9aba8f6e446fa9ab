// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scans: which space a range sensor saw to be empty at the moment of a view. A map holds everything that ever was
/// measured, also the trail of a van; what the scan of that moment saw through was not there.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>
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

/// What a scan measured: the nearest range of every cell, and up to where it is empty.
struct ScanRanges {
  cv::Mat1w measured, empty;

  std::size_t numBytes() const { return (measured.total() + empty.total()) * sizeof(std::uint16_t); }
};
inline ScanRanges scanRanges(const cv::Mat1w& panorama) {
  return {panorama, emptyRanges(panorama)};
}

/// What a scan tells of a place: nothing; that it saw through it; that it ended there; that it ended before.
enum class ScanEvidence { kNothing, kEmpty, kSurface, kBehind };

/// A scan, and where it was taken.
class PlacedScan {
 public:
  PlacedScan(std::shared_ptr<const ScanRanges> ranges, const Eigen::Isometry3f& sensor_from_frame);

  ScanEvidence at(const Eigen::Vector3f& place) const;  ///< m, in the frame
  Eigen::Vector3f inSensor(const Eigen::Vector3f& place) const { return rotation_ * place + translation_; }
  /// m, the nearest range in the direction of a place in the sensor's frame; 0 where the cell has none.
  float measuredAt(const Eigen::Vector3f& in_sensor) const;
  float cellAngle() const;  ///< rad that a cell spans at the horizon
  std::size_t numBytes() const { return ranges_->numBytes(); }

 private:
  std::shared_ptr<const ScanRanges> ranges_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
};

/// What the scans of a view's moment tell of the space in front of its camera.
class EmptySpace {
 public:
  void add(PlacedScan scan) { scans_.push_back(std::move(scan)); }

  /// Whether a scan saw through the place [m, in the camera's frame], and no other has it that something was there.
  bool contains(const Eigen::Vector3f& point) const;
  /// Whether a scan ended there: what the map holds at the place was there at that moment.
  bool confirms(const Eigen::Vector3f& point) const;
  /// Whether a scan measured the surface at `point` [m, in the camera's frame] and looked through what seems to hide it
  /// at `distance` [m] from the camera, and no other scan has it otherwise. `tolerance`: m of range that measurements
  /// may differ by; `tangent`: of the angle of incidence, as a cell of a scan has the nearest of a slanted surface.
  bool uncovers(const Eigen::Vector3f& point, float distance, float tolerance, float tangent) const;
  /// Whether a scan measured a range to `point` that differs by at most `share` of it: it was there and in sight.
  bool measured(const Eigen::Vector3f& point, float share) const;
  bool knowsNothing() const { return scans_.empty(); }
  std::size_t numBytes() const;

 private:
  std::vector<PlacedScan> scans_;
};

}  // namespace cloud_colorizer
