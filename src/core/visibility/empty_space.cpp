// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/empty_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kStepsPerMetre = 256;
constexpr int kFarthest = std::numeric_limits<std::uint16_t>::max();
constexpr double kMargin = 0.3, kMarginShare = 0.05;  // m, and share of the range: what noise and slant may hide

/// Steps that noise and slant may hide of a range in steps.
double marginOf(double range) {
  return std::max(kMargin * kStepsPerMetre, kMarginShare * range);
}

/// atan2 / (2 pi) to 2e-5: a cell is seventy times as wide, and this is called for every point in every view.
float turnOf(float y, float x) {
  const float across = std::abs(y), along = std::abs(x);
  const float a = std::min(across, along) / std::max(1e-30F, std::max(across, along)), s = a * a;
  float turn = ((-0.0464964749F * s + 0.15931422F) * s - 0.327622764F) * s * a + a;
  turn *= static_cast<float>(0.5 / M_PI);
  if (across > along) turn = 0.25F - turn;
  if (x < 0) turn = 0.5F - turn;
  return y < 0 ? -turn : turn;
}

/// Column and row of a direction; `range` is its length.
cv::Point cellOf(const Eigen::Vector3f& direction, float range, int cols, int rows) {
  const float height = 0.5F - 0.5F * direction.z() / range;
  const float turn = 0.5F + turnOf(direction.y(), direction.x());
  return {std::min(cols - 1, static_cast<int>(turn * static_cast<float>(cols))),
          std::min(rows - 1, static_cast<int>(height * static_cast<float>(rows)))};
}

}  // namespace

cv::Mat1w makeRangePanorama(const Eigen::Matrix3Xd& positions, double resolution, double min_range) {
  requireInRange("scan_resolution", resolution, 0.05, 30.0);
  const int cols = static_cast<int>(std::lround(360 / resolution));
  const int rows = static_cast<int>(std::lround(360 / M_PI / resolution));
  cv::Mat1w panorama(rows, cols, std::uint16_t{0});
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    const Eigen::Vector3d position = positions.col(i);
    const double range = position.norm();
    if (!(range >= min_range && range > 0 && std::isfinite(range))) continue;
    const auto steps = static_cast<std::uint16_t>(std::clamp(range * kStepsPerMetre, 1.0, double{kFarthest}));
    std::uint16_t& cell = panorama(cellOf(position.cast<float>(), static_cast<float>(range), cols, rows));
    if (cell == 0 || steps < cell) cell = steps;
  }
  return panorama;
}

cv::Mat1w emptyRanges(const cv::Mat1w& panorama) {
  cv::Mat1w known = panorama.clone(), nearest;
  known.setTo(kFarthest, panorama == 0);
  cv::copyMakeBorder(known, known, 0, 0, 1, 1, cv::BORDER_WRAP);
  cv::erode(known, nearest, cv::Mat());  // 3 x 3
  cv::Mat1w ranges(panorama.size(), std::uint16_t{0});
  for (int row = 0; row < panorama.rows; ++row) {
    for (int col = 0; col < panorama.cols; ++col) {
      if (panorama(row, col) == 0) continue;
      const double range = nearest(row, col + 1);
      ranges(row, col) = static_cast<std::uint16_t>(std::max(1.0, range - marginOf(range)));
    }
  }
  return ranges;
}

PlacedScan::PlacedScan(std::shared_ptr<const ScanRanges> ranges, const Eigen::Isometry3f& sensor_from_frame)
    : ranges_(std::move(ranges)),
      rotation_(sensor_from_frame.linear()),
      translation_(sensor_from_frame.translation()) {}

ScanEvidence PlacedScan::at(const Eigen::Vector3f& place) const {
  const Eigen::Vector3f direction = inSensor(place);
  const float range = direction.norm();
  if (!(range > 0)) return ScanEvidence::kBehind;
  const std::uint16_t empty = ranges_->empty(cellOf(direction, range, ranges_->empty.cols, ranges_->empty.rows));
  if (empty == 0) return ScanEvidence::kNothing;
  const float beyond = range * static_cast<float>(kStepsPerMetre) - static_cast<float>(empty);
  if (beyond < 0) return ScanEvidence::kEmpty;
  return beyond <= 2 * static_cast<float>(marginOf(empty)) ? ScanEvidence::kSurface : ScanEvidence::kBehind;
}

float PlacedScan::measuredAt(const Eigen::Vector3f& in_sensor) const {
  const float range = in_sensor.norm();
  if (!(range > 0)) return 0;
  const cv::Mat1w& measured = ranges_->measured;
  return static_cast<float>(measured(cellOf(in_sensor, range, measured.cols, measured.rows))) /
         static_cast<float>(kStepsPerMetre);
}

float PlacedScan::cellAngle() const {
  return static_cast<float>(2 * M_PI) / static_cast<float>(ranges_->measured.cols);
}

bool EmptySpace::contains(const Eigen::Vector3f& point) const {
  bool seen_through = false;
  for (const PlacedScan& scan : scans_) {
    const ScanEvidence evidence = scan.at(point);
    if (evidence == ScanEvidence::kSurface || evidence == ScanEvidence::kBehind) return false;
    seen_through = seen_through || evidence == ScanEvidence::kEmpty;
  }
  return seen_through;
}

bool EmptySpace::confirms(const Eigen::Vector3f& point) const {
  return std::any_of(scans_.begin(), scans_.end(),
                     [&](const PlacedScan& scan) { return scan.at(point) == ScanEvidence::kSurface; });
}

bool EmptySpace::uncovers(const Eigen::Vector3f& point, float distance, float tolerance, float tangent) const {
  bool measured = false;
  const Eigen::Vector3f occluder = point * (distance / point.norm());
  for (const PlacedScan& scan : scans_) {
    const Eigen::Vector3f place = scan.inSensor(point);
    const float range = place.norm(), found = scan.measuredAt(place);
    if (found == 0) continue;
    // A cell holds the nearest range in it: of a slanted surface less than that of its middle.
    const float slack = tolerance + scan.cellAngle() * range * tangent;
    if (std::abs(range - found) > slack) return false;
    const Eigen::Vector3f before = scan.inSensor(occluder);
    if (!(scan.measuredAt(before) > before.norm() + tolerance)) return false;
    measured = true;
  }
  return measured;
}

bool EmptySpace::measured(const Eigen::Vector3f& point, float share) const {
  return std::any_of(scans_.begin(), scans_.end(), [&](const PlacedScan& scan) {
    const Eigen::Vector3f place = scan.inSensor(point);
    const float range = place.norm();
    return std::abs(range - scan.measuredAt(place)) <= share * range;
  });
}

std::size_t EmptySpace::numBytes() const {
  std::size_t bytes = 0;
  for (const PlacedScan& scan : scans_) bytes += scan.numBytes();
  return bytes;
}

}  // namespace cloud_colorizer
