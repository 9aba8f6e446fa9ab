// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Poses that another program wrote.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cloud_colorizer {

struct TrajectoryPose {
  std::optional<std::int64_t> stamp;  ///< ns; empty: the file has none
  Eigen::Isometry3d map_from_base = Eigen::Isometry3d::Identity();
};

/// Reads a text file with a pose a line; empty lines and comments (#) are passed over:
///   TUM     stamp [s] x y z qx qy qz qw, ascending stamps
///   KITTI   the 3 x 4 matrix row by row, without stamps
/// Throws std::runtime_error with file, line and reason.
std::vector<TrajectoryPose> readTrajectory(const std::string& path);

}  // namespace cloud_colorizer
