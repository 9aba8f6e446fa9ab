// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Blocks of tiles: lengths that follow the density of points, where the size of a tile is the recorder's choice.
#pragma once

#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// Tiles along the side of a block, a power of two. Without voxels, where a place may hold any number of points, tiles
/// are small.
inline int tilesPerBlock(const Recording& recording) {
  return recording.voxelSize() > 0 ? 1 : 4;
}

/// m, a side.
inline double blockSize(const Recording& recording) {
  return recording.tileSize() * tilesPerBlock(recording);
}

}  // namespace cloud_colorizer
