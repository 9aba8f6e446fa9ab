// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/seams.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/robust.hpp"
#include "cloud_colorizer/map/chunks.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kPointsAcross = 3;       // of a cell, where the points of a tile lie on one flat surface
constexpr std::size_t kEnoughCells = 20;  // on borders
constexpr double kErrors = 3;             // standard errors that are no seam

double typicalPoints(const std::vector<Tile>& tiles) {
  std::vector<std::size_t> counts;
  counts.reserve(tiles.size());
  for (const Tile& tile : tiles) counts.push_back(tile.num_points);
  return std::max(1.0, static_cast<double>(median(std::move(counts))));
}

}  // namespace

SeamMeter::SeamMeter(const Recording& recording, const Params& params)
    : recording_(recording),
      chunk_of_(recording.tiles().size()),
      reach_(static_cast<float>(recording.tileSize() *
                                std::min(0.5, kPointsAcross / std::sqrt(typicalPoints(recording.tiles()))))) {
  const std::vector<Chunk> chunks = planChunks(recording.tiles(), recording.tileSize(), params.chunks);
  for (std::size_t chunk = 0; chunk < chunks.size(); ++chunk) {
    for (const std::size_t tile : chunks[chunk].core_tiles) chunk_of_[tile] = chunk;
  }
}

SeamMeter::Side SeamMeter::sideOf(const ShownTile& shown, int axis, bool high) const {
  const Eigen::AlignedBox3f box = recording_.tileBox(shown.tile);
  const float plane = high ? box.max()[axis] : box.min()[axis];
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Side side;
  for (Eigen::Index i = 0; i < shown.points.cols(); ++i) {
    const auto point = shown.points.col(i);
    const float distance = std::abs(point[axis] - plane);
    if (shown.colors.count[static_cast<std::size_t>(i)] == 0 || distance > 2 * reach_) continue;
    Column& column = side[{static_cast<std::int32_t>(std::floor(point[u] / reach_)),
                           static_cast<std::int32_t>(std::floor(point[v] / reach_))}];
    (distance > reach_ ? column.far : column.near).add(shown.colors.values.col(i).head<3>());
  }
  return side;
}

void SeamMeter::compare(const Side& low, const Side& high) {
  const auto step = [](const Color& a, const Color& b) {
    return static_cast<double>((a.sum / a.count - b.sum / b.count).cwiseAbs().mean());
  };
  for (const auto& [cell, column] : high) {
    const auto across = low.find(cell);
    if (across == low.end()) continue;
    const Column& there = across->second;
    if (std::min({column.near.count, column.far.count, there.near.count, there.far.count}) == 0) continue;
    const double more =
        step(column.near, there.near) - (step(column.near, column.far) + step(there.near, there.far)) / 2;
    sum_ += more;
    squares_ += more * more;
    ++count_;
  }
}

void SeamMeter::add(const ShownTile& shown) {
  const auto& tiles = recording_.tiles();
  const TileIndex index = tiles[shown.tile].index;
  const auto chunkAt = [&](const TileIndex& at) -> std::optional<std::size_t> {
    const auto tile = std::lower_bound(tiles.begin(), tiles.end(), at,
                                       [](const Tile& other, const TileIndex& wanted) { return other.index < wanted; });
    if (tile == tiles.end() || tile->index != at) return std::nullopt;
    return chunk_of_[static_cast<std::size_t>(tile - tiles.begin())];
  };
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = open_.find({axis, index[0], index[1], index[2]});
    if (found != open_.end()) {
      compare(found->second, sideOf(shown, axis, false));
      open_.erase(found);
    }
    TileIndex beyond = index;
    ++beyond[static_cast<std::size_t>(axis)];
    const auto chunk = chunkAt(beyond);
    if (chunk && *chunk != chunk_of_[shown.tile]) {
      open_[{axis, beyond[0], beyond[1], beyond[2]}] = sideOf(shown, axis, true);
    }
  }
}

double SeamMeter::excess() const {
  if (count_ < kEnoughCells) return 0;
  const auto count = static_cast<double>(count_);
  const double mean = sum_ / count, error = std::sqrt(std::max(0.0, squares_ / count - mean * mean) / count);
  return std::max(0.0, mean - kErrors * error);
}

}  // namespace cloud_colorizer
