// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/scan_log.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"
#include "recording/recording_files.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kScanShare = 0.25;  ///< of the motion between keyframes: between scans

}  // namespace

ScanLog::ScanLog(const std::string& directory, const RecordParams& params)
    : directory_(directory), params_(params), table_(TableWriter::ofScans(directory)) {
  scans_ = readScans(directory).rows;
  for (const Scan& scan : scans_) earlier_.emplace(formatFixed(scan.stamp, 9), scan.map_from_sensor);
}

bool ScanLog::hasMoved(const std::string& sensor, const Eigen::Isometry3d& map_from_sensor) const {
  const auto last = last_.find(sensor);
  if (last == last_.end()) return true;
  const Eigen::Isometry3d moved = last->second.inverse() * map_from_sensor;
  const double degrees = Eigen::AngleAxisd(moved.linear()).angle() * 180 / M_PI;
  return moved.translation().norm() >= kScanShare * params_.keyframe_distance ||
         degrees >= kScanShare * params_.keyframe_angle;
}

/// Once for each: same stamp and same pose, as sensors may share their clock.
bool ScanLog::recognize(const Scan& scan) {
  const auto [first, last] = earlier_.equal_range(formatFixed(scan.stamp, 9));
  const auto found = std::find_if(
      first, last, [&](const auto& earlier) { return earlier.second.isApprox(scan.map_from_sensor, 1e-6); });
  if (found == last) return false;
  earlier_.erase(found);
  return true;
}

void ScanLog::add(const std::string& sensor, double stamp, const Eigen::Matrix3Xd& positions,
                  const Eigen::Isometry3d& map_from_sensor, const Eigen::Vector3d& origin) {
  require<std::invalid_argument>(std::isfinite(stamp), "the stamp of a scan must be finite, not ", stamp);
  if (!hasMoved(sensor, map_from_sensor)) return;
  Scan scan{stamp, map_from_sensor, "scans/" + sixDigits(scans_.size()) + ".png"};
  scan.map_from_sensor.translation() -= origin;
  if (!recognize(scan)) {
    std::vector<std::uint8_t> png;
    cv::imencode(".png", makeRangePanorama(positions, params_.scan_resolution, params_.min_range), png,
                 {cv::IMWRITE_PNG_COMPRESSION, 1});
    makeFolder(directory_, "scans");
    writeFileAtomically(directory_ + '/' + scan.image, png.data(), png.size());
    table_.append(scanLine(scan));
    scan.map_from_sensor = poseInTable(scan.map_from_sensor);
    scans_.push_back(std::move(scan));
  }
  last_[sensor] = map_from_sensor;
}

}  // namespace cloud_colorizer
