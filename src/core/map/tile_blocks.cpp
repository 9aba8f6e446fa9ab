// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/tile_blocks.hpp"

#include <array>
#include <map>

namespace cloud_colorizer {
namespace {

void addCubes(const Recording& recording, const TileIds& tiles, std::size_t most, std::int64_t side,
              std::vector<TileIds>& cubes) {
  std::map<std::array<std::int64_t, 3>, TileIds> by_index;
  for (const std::size_t tile : tiles) {
    std::array<std::int64_t, 3> cube{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t i = recording.tiles()[tile].index[axis];
      cube[axis] = (i - (i % side + side) % side) / side;
    }
    by_index[cube].push_back(tile);
  }
  for (const auto& [index, cube] : by_index) {
    if (side == 1 || countPoints(recording.tiles(), cube) <= most) {
      cubes.push_back(cube);
    } else {
      addCubes(recording, cube, most, side / 2, cubes);
    }
  }
}

/// So that at most eight cubes, those around the origin, hold all tiles.
std::int64_t sideOfAll(const Recording& recording) {
  std::int64_t side = 1;
  for (const Tile& tile : recording.tiles()) {
    for (const std::int64_t i : tile.index) {
      while (i >= side || i < -side) side *= 2;
    }
  }
  return side;
}

}  // namespace

std::vector<TileIds> cubesOfTiles(const Recording& recording, const TileIds& tiles, std::size_t most,
                                  std::int64_t side) {
  std::vector<TileIds> cubes;
  addCubes(recording, tiles, most, side > 0 ? side : sideOfAll(recording), cubes);
  return cubes;
}

}  // namespace cloud_colorizer
