// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// From a cloud in its sensor's frame to stored positions and their tiles.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "cloud_colorizer/recording/recorder.hpp"
#include "recording/tile_grid.hpp"
#include "recording/tile_writer.hpp"

namespace cloud_colorizer {

/// Where the first point within the ranges lies; none: there is no such point.
std::optional<Eigen::Vector3d> firstInRange(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                                            const RecordParams& params);

/// The points within the ranges and the grid. `relative_from_sensor` leads to positions relative to the origin.
void placePoints(const Cloud& cloud, const Eigen::Isometry3d& relative_from_sensor, const RecordParams& params,
                 const TileGrid& grid, std::vector<PlacedPoint>& placed, Recorder::InsertCounts& counts);

}  // namespace cloud_colorizer
