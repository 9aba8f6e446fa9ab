// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/chunks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "cloud_colorizer/base/check.hpp"
#include "recording/tile_range.hpp"

namespace cloud_colorizer {
namespace {

using TileIds = std::vector<std::size_t>;

/// A cube of 2^k tiles, and the tiles in it.
struct Cube {
  std::array<std::int64_t, 3> index{};
  std::int64_t side = 1;
  TileIds tiles;
};

std::size_t countPoints(const std::vector<Tile>& tiles, const TileIds& ids) {
  return std::accumulate(ids.begin(), ids.end(), std::size_t{0},
                         [&](std::size_t sum, std::size_t id) { return sum + tiles[id].num_points; });
}

std::int64_t floorTo(std::int64_t value, std::int64_t step) {
  return (value >= 0 ? value / step : -((-value + step - 1) / step)) * step;
}

/// The smallest cubes of a power of two that together hold all tiles: aligned to their own side, at most eight.
std::vector<Cube> rootCubes(const std::vector<Tile>& tiles) {
  std::array<std::int64_t, 3> low{}, high{};
  low.fill(std::numeric_limits<std::int64_t>::max());
  high.fill(std::numeric_limits<std::int64_t>::min());
  for (const auto& tile : tiles) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<std::int64_t>(low[axis], tile.index[axis]);
      high[axis] = std::max<std::int64_t>(high[axis], tile.index[axis]);
    }
  }
  std::int64_t side = 1;
  const auto spans = [&](std::size_t axis) { return floorTo(high[axis], side) - floorTo(low[axis], side) > side; };
  while (spans(0) || spans(1) || spans(2)) side *= 2;

  std::vector<Cube> cubes;
  for (std::int64_t x = floorTo(low[0], side); x <= high[0]; x += side)
    for (std::int64_t y = floorTo(low[1], side); y <= high[1]; y += side)
      for (std::int64_t z = floorTo(low[2], side); z <= high[2]; z += side) cubes.push_back({{x, y, z}, side, {}});
  for (std::size_t id = 0; id < tiles.size(); ++id) {
    for (auto& cube : cubes) {
      bool inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t offset = tiles[id].index[axis] - cube.index[axis];
        inside = inside && offset >= 0 && offset < cube.side;
      }
      if (inside) cube.tiles.push_back(id);
    }
  }
  return cubes;
}

std::array<Cube, 8> splitCube(const Cube& cube, const std::vector<Tile>& tiles) {
  std::array<Cube, 8> children;
  const std::int64_t half = cube.side / 2;
  for (std::size_t octant = 0; octant < 8; ++octant) {
    children[octant].side = half;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      children[octant].index[axis] = cube.index[axis] + ((octant >> axis) & 1U ? half : 0);
    }
  }
  for (const std::size_t id : cube.tiles) {
    std::size_t octant = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (tiles[id].index[axis] >= cube.index[axis] + half) octant |= std::size_t{1} << axis;
    }
    children[octant].tiles.push_back(id);
  }
  return children;
}

Chunk makeChunk(const Cube& cube, const std::vector<Tile>& tiles, double tile_size, double overlap) {
  Chunk chunk;
  for (std::size_t axis = 0; axis < 3; ++axis) chunk.index[axis] = static_cast<std::int32_t>(cube.index[axis]);
  const auto lowCorner = [tile_size](const TileIndex& index) -> Eigen::Array3d {
    return Eigen::Array3d(index[0], index[1], index[2]) * tile_size;
  };
  chunk.side = static_cast<std::int32_t>(cube.side);
  chunk.core_tiles = cube.tiles;
  chunk.num_core_points = countPoints(tiles, cube.tiles);

  const Eigen::Array3d low = lowCorner(chunk.index);
  const double side = static_cast<double>(cube.side) * tile_size;
  const double halo = overlap * side;
  chunk.box_with_halo = {(low - halo).matrix().cast<float>(), (low + side + halo).matrix().cast<float>()};
  chunk.num_points_with_halo = static_cast<double>(chunk.num_core_points);
  if (halo <= 0) return chunk;
  for (const std::size_t id : tilesAround(tiles, tile_size, chunk.box_with_halo.cast<double>())) {
    const Eigen::Array3d tile_low = lowCorner(tiles[id].index);
    const Eigen::Array3d common = (tile_low + tile_size).min(low + side + halo) - tile_low.max(low - halo);
    if (!(common > 0).all() || std::binary_search(chunk.core_tiles.begin(), chunk.core_tiles.end(), id)) continue;
    chunk.halo_tiles.push_back(id);
    chunk.num_points_with_halo += static_cast<double>(tiles[id].num_points) * (common / tile_size).prod();
  }
  return chunk;
}

}  // namespace

void ChunkParams::check() const {
  requireInRange("max_chunk_points", max_chunk_points, 1000, 100000000);
  requireInRange("overlap", overlap, 0.0, 0.5);
}

double ChunkParams::maxPointsWithHalo() const {
  return max_chunk_points * std::pow(1 + 2 * overlap, 2);
}

std::vector<Chunk> planChunks(const std::vector<Tile>& tiles, double tile_size, const ChunkParams& params) {
  params.check();
  if (tiles.empty()) return {};
  std::vector<Cube> open = rootCubes(tiles);
  std::vector<Chunk> chunks;
  while (!open.empty()) {
    const Cube cube = std::move(open.back());
    open.pop_back();
    if (cube.tiles.empty()) continue;
    const bool is_tile = cube.side == 1;
    if (is_tile || countPoints(tiles, cube.tiles) <= static_cast<std::size_t>(params.max_chunk_points)) {
      Chunk chunk = makeChunk(cube, tiles, tile_size, params.overlap);
      // A large cube of few points beside a dense place would have many times its own points in its halo.
      if (is_tile || chunk.num_points_with_halo <= params.maxPointsWithHalo()) {
        chunks.push_back(std::move(chunk));
        continue;
      }
    }
    for (auto& child : splitCube(cube, tiles)) open.push_back(std::move(child));
  }
  std::sort(chunks.begin(), chunks.end(),
            [](const Chunk& a, const Chunk& b) { return a.core_tiles.front() < b.core_tiles.front(); });
  return chunks;
}

}  // namespace cloud_colorizer
