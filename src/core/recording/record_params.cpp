// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "recording/voxel_set.hpp"

namespace cloud_colorizer {

void RecordParams::check() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  requireInRange("voxel_size", voxel_size, 0.0, 1000.0);
  require<std::invalid_argument>(voxel_size == 0 || voxel_size >= 1e-6, "parameter voxel_size = ", voxel_size,
                                 " must be 0 or at least 1e-6 m");
  requireInRange("min_range", min_range, 0.0, kInfinity);
  requireInRange("max_range", max_range, min_range, kInfinity);
  requireInRange("tile_size", tile_size, 0.0, 1e6);
  requireInRange("keyframe_distance", keyframe_distance, 0.0, kInfinity);
  requireInRange("keyframe_angle", keyframe_angle, 0.0, 360.0);
  require<std::invalid_argument>(scan_resolution == 0 || (scan_resolution >= 0.05 && scan_resolution <= 30),
                                 "parameter scan_resolution = ", scan_resolution, " must be 0 or 0.05 to 30 deg");
  requireInRange("max_open_tiles", max_open_tiles, 1, 1'000'000);
  if (voxel_size == 0 || tile_size == 0) return;
  const double side = tile_size / voxel_size;
  const double whole = std::max(1.0, std::round(side));
  require<std::invalid_argument>(std::abs(side - whole) < 1e-6 * whole, "parameter tile_size = ", tile_size,
                                 " must be a whole multiple of voxel_size = ", voxel_size, ", for example ",
                                 whole * voxel_size);
  require<std::invalid_argument>(whole <= VoxelSet::kMaxSide, "parameter tile_size = ", tile_size, " must be at most ",
                                 VoxelSet::kMaxSide, " times voxel_size = ", voxel_size);
}

}  // namespace cloud_colorizer
