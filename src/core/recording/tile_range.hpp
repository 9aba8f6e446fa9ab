// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tiles around a place, without a look at all others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// Into Recording::tiles(), ascending.
using TileIds = std::vector<std::size_t>;

/// Of all tiles.
inline TileIds allTiles(const std::vector<Tile>& tiles) {
  TileIds ids(tiles.size());
  std::iota(ids.begin(), ids.end(), std::size_t{0});
  return ids;
}

/// Of the tiles `ids`, all together.
inline std::size_t countPoints(const std::vector<Tile>& tiles, const TileIds& ids) {
  return std::accumulate(ids.begin(), ids.end(), std::size_t{0},
                         [&](std::size_t sum, std::size_t id) { return sum + tiles[id].num_points; });
}

/// Of `tiles`, which ascend by index: those that touch the box [m], and some within a tile of it. Ascending.
/// Takes a search for each row of tiles that the box crosses, or for each of these that is there.
inline std::vector<std::size_t> tilesAround(const std::vector<Tile>& tiles, double tile_size,
                                            const Eigen::AlignedBox3d& box) {
  const auto indexOf = [&](double coordinate, double beyond) {
    constexpr double kLeast = std::numeric_limits<std::int32_t>::min(), kMost = -(kLeast + 1);
    return static_cast<std::int32_t>(std::clamp(std::floor(coordinate / tile_size) + beyond, kLeast, kMost - 1));
  };
  TileIndex low{}, high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = indexOf(box.min()[static_cast<Eigen::Index>(axis)], -1);
    high[axis] = indexOf(box.max()[static_cast<Eigen::Index>(axis)], 1);
  }
  const auto from = [](const Tile& tile, const TileIndex& index) { return tile.index < index; };
  std::vector<std::size_t> found;
  auto tile = std::lower_bound(tiles.begin(), tiles.end(), low, from);
  while (tile != tiles.end() && tile->index <= high) {
    std::size_t axis = 0;
    while (axis < 3 && low[axis] <= tile->index[axis] && tile->index[axis] <= high[axis]) ++axis;
    if (axis == 3) {
      found.push_back(static_cast<std::size_t>(tile++ - tiles.begin()));
      continue;
    }
    TileIndex next = tile->index;  // the least one after it that is in the box along this axis and the later ones
    if (next[axis] > high[axis]) ++next[axis - 1];
    std::copy(low.begin() + static_cast<std::ptrdiff_t>(axis), low.end(),
              next.begin() + static_cast<std::ptrdiff_t>(axis));
    tile = std::lower_bound(tile, tiles.end(), next, from);
  }
  return found;
}

}  // namespace cloud_colorizer
