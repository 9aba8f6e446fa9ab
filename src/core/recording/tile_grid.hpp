// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Which tile and which voxel a stored (float) position lies in. The same numbers give the same answer when a tile is
/// read back, so a recording that is continued thins exactly as if it had never stopped.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

struct TileCell {
  TileIndex tile{};
  std::array<std::uint32_t, 3> voxel{};  ///< in the tile; zero without voxels
};

class TileGrid {
 public:
  TileGrid(double voxel_size, double tile_size)
      : cells_per_meter_(1 / (voxel_size > 0 ? voxel_size : tile_size)),
        side_(voxel_size > 0 ? std::llround(tile_size / voxel_size) : 1),
        limit_(std::min(kMaxCoordinate, tile_size * (std::numeric_limits<std::int32_t>::max() - 1))) {}

  /// 10,000 km, where a float still has steps of 1 m, and what the tile index can count.
  static constexpr double kMaxCoordinate = 1e7;
  double limit() const { return limit_; }

  /// Of a position, relative to the origin, whose coordinates are within limit().
  TileCell cellOf(const float* position) const {
    TileCell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto index = floorToInt(static_cast<double>(position[axis]) * cells_per_meter_);
      const auto tile = floorToInt((static_cast<double>(index) + 0.5) / static_cast<double>(side_));
      cell.tile[axis] = static_cast<std::int32_t>(tile);
      cell.voxel[axis] = static_cast<std::uint32_t>(index - tile * side_);
    }
    return cell;
  }

 private:
  static std::int64_t floorToInt(double value) {
    const auto truncated = static_cast<std::int64_t>(value);
    return truncated - static_cast<std::int64_t>(static_cast<double>(truncated) > value);
  }

  double cells_per_meter_;
  std::int64_t side_;  ///< cells of a tile
  double limit_;
};

}  // namespace cloud_colorizer
