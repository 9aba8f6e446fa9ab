// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/chunks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "cloud_colorizer/base/check.hpp"
#include "recording/tile_range.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kFloorCost = 8;  // floors and roads are flat: all their points may lie beside one cut along z
constexpr double kLeastShare = 0.25;   // of the points on each side of a cut, where there is such a cut

/// Between the layers of tiles `before` and `before + 1` along an axis.
struct Cut {
  std::size_t axis = 0;
  std::int32_t before = 0;
  std::size_t beside = 0;   ///< points in both layers
  std::size_t smaller = 0;  ///< points of the side with fewer

  /// Enough points on both sides come first, then few beside it, then the middle.
  bool isBetterThan(const Cut& other, std::size_t enough) const {
    const bool is_even = smaller >= enough, other_is_even = other.smaller >= enough;
    if (is_even != other_is_even) return is_even;
    if (is_even && beside != other.beside) return beside < other.beside;
    return smaller > other.smaller;
  }
};

/// Nothing where all tiles are in one layer along each axis, i.e. are one tile.
std::optional<Cut> bestCut(const std::vector<Tile>& tiles, const TileIds& ids) {
  const std::size_t all = countPoints(tiles, ids);
  const auto enough = static_cast<std::size_t>(kLeastShare * static_cast<double>(all));
  std::optional<Cut> best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::map<std::int32_t, std::size_t> layers;
    for (const std::size_t id : ids) layers[tiles[id].index[axis]] += tiles[id].num_points;
    std::size_t below = 0;
    for (auto layer = layers.begin(); std::next(layer) != layers.end(); ++layer) {
      const auto next = std::next(layer);
      below += layer->second;
      const bool touch = next->first == layer->first + 1;
      const std::size_t beside = touch ? layer->second + next->second : 0;
      const Cut cut{axis, layer->first, axis == 2 ? kFloorCost * beside : beside, std::min(below, all - below)};
      if (!best || cut.isBetterThan(*best, enough)) best = cut;
    }
  }
  return best;
}

Chunk makeChunk(const TileIds& ids, const std::vector<Tile>& tiles, double tile_size, double overlap) {
  Chunk chunk;
  chunk.low.fill(std::numeric_limits<std::int32_t>::max());
  chunk.high.fill(std::numeric_limits<std::int32_t>::min());
  for (const std::size_t id : ids) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      chunk.low[axis] = std::min(chunk.low[axis], tiles[id].index[axis]);
      chunk.high[axis] = std::max(chunk.high[axis], tiles[id].index[axis] + 1);
    }
  }
  const auto cornerOf = [tile_size](const TileIndex& index) -> Eigen::Array3d {
    return Eigen::Array3d(index[0], index[1], index[2]) * tile_size;
  };
  chunk.core_tiles = ids;
  chunk.num_core_points = countPoints(tiles, ids);

  const Eigen::Array3d low = cornerOf(chunk.low), high = cornerOf(chunk.high);
  Eigen::Array3d sides = high - low;
  std::sort(sides.data(), sides.data() + 3);
  const double halo = overlap * sides[1];
  chunk.box_with_halo = {(low - halo).matrix().cast<float>(), (high + halo).matrix().cast<float>()};
  chunk.num_points_with_halo = static_cast<double>(chunk.num_core_points);
  if (halo <= 0) return chunk;
  for (const std::size_t id : tilesAround(tiles, tile_size, chunk.box_with_halo.cast<double>())) {
    const Eigen::Array3d tile_low = cornerOf(tiles[id].index);
    const Eigen::Array3d common = (tile_low + tile_size).min(high + halo) - tile_low.max(low - halo);
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
  std::vector<TileIds> open(1, allTiles(tiles));
  std::vector<Chunk> chunks;
  while (!tiles.empty() && !open.empty()) {
    const TileIds ids = std::move(open.back());
    open.pop_back();
    const std::optional<Cut> cut = bestCut(tiles, ids);
    if (!cut || countPoints(tiles, ids) <= static_cast<std::size_t>(params.max_chunk_points)) {
      Chunk chunk = makeChunk(ids, tiles, tile_size, params.overlap);
      // Few points beside a dense place would have many times their number in their halo.
      if (!cut || chunk.num_points_with_halo <= params.maxPointsWithHalo()) {
        chunks.push_back(std::move(chunk));
        continue;
      }
    }
    std::array<TileIds, 2> sides;
    for (const std::size_t id : ids) sides[tiles[id].index[cut->axis] <= cut->before ? 1 : 0].push_back(id);
    for (TileIds& side : sides) open.push_back(std::move(side));
  }
  return chunks;
}

}  // namespace cloud_colorizer
