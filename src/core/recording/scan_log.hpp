// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The scans of a recording that is being filled: which are kept, scans.csv, and the images of ranges.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "cloud_colorizer/recording/recorder.hpp"
#include "recording/recording_tables.hpp"

namespace cloud_colorizer {

class ScanLog {
 public:
  ScanLog(const std::string& directory, const RecordParams& params);

  const std::vector<Scan>& scans() const { return scans_; }
  /// See Recorder::addScan. `origin` is the recording's.
  void add(const std::string& sensor, double stamp, const Eigen::Matrix3Xd& positions,
           const Eigen::Isometry3d& map_from_sensor, const Eigen::Vector3d& origin);

 private:
  bool hasMoved(const std::string& sensor, const Eigen::Isometry3d& map_from_sensor) const;
  bool recognize(const Scan& scan);

  std::string directory_;
  RecordParams params_;
  TableWriter table_;
  std::vector<Scan> scans_;
  std::multimap<std::string, Eigen::Isometry3d> earlier_;  ///< by stamp, what an earlier program recorded
  std::map<std::string, Eigen::Isometry3d> last_;          ///< pose of every sensor's last one
};

}  // namespace cloud_colorizer
