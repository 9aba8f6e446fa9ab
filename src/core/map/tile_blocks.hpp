// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Blocks of tiles: lengths that follow the density of points, where the size of a tile is the recorder's choice.
#pragma once

#include <vector>

#include "cloud_colorizer/recording/recording.hpp"
#include "recording/tile_range.hpp"

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

/// The tiles in cubes of `side` of them, a power of two; those with more points than `most` in smaller ones, down to a
/// tile. With a side of 0, as large as need be.
std::vector<TileIds> cubesOfTiles(const Recording& recording, const TileIds& tiles, std::size_t most,
                                  std::int64_t side = 0);

}  // namespace cloud_colorizer
