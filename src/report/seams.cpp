// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/seams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/robust.hpp"
#include "cloud_colorizer/map/chunks.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kPointsAcross = 3;       // of a cell, where the points of a tile lie on one flat surface
constexpr std::size_t kEnoughCells = 20;  // on borders, and inside

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
    if (shown.colors.count[static_cast<std::size_t>(i)] == 0 || std::abs(point[axis] - plane) > reach_) continue;
    Color& color = side[{static_cast<std::int32_t>(std::floor(point[u] / reach_)),
                         static_cast<std::int32_t>(std::floor(point[v] / reach_))}];
    color.sum += shown.colors.values.col(i).head<3>();
    ++color.count;
  }
  return side;
}

void SeamMeter::add(const ShownTile& shown) {
  const TileIndex index = recording_.tiles()[shown.tile].index;
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = open_.find({axis, index[0], index[1], index[2]});
    if (found != open_.end()) {
      TileIndex before = index;
      --before[static_cast<std::size_t>(axis)];
      const auto& tiles = recording_.tiles();
      const auto other = std::lower_bound(tiles.begin(), tiles.end(), before,
                                          [](const Tile& tile, const TileIndex& at) { return tile.index < at; });
      const bool is_border = chunk_of_[static_cast<std::size_t>(other - tiles.begin())] != chunk_of_[shown.tile];
      Steps& steps = is_border ? border_ : inside_;
      for (const auto& [cell, color] : sideOf(shown, axis, false)) {
        const auto across = found->second.find(cell);
        if (across == found->second.end()) continue;
        const Color& there = across->second;
        steps.sum += static_cast<double>((color.sum / color.count - there.sum / there.count).cwiseAbs().mean());
        ++steps.count;
      }
      open_.erase(found);
    }
    TileIndex beyond = index;
    ++beyond[static_cast<std::size_t>(axis)];
    Side side = sideOf(shown, axis, true);
    if (!side.empty()) open_[{axis, beyond[0], beyond[1], beyond[2]}] = std::move(side);
    // Tiles ascend by x: those before will not come.
    constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
    open_.erase(open_.lower_bound({axis, kLeast, kLeast, kLeast}), open_.lower_bound({axis, index[0], kLeast, kLeast}));
  }
}

double SeamMeter::excess() const {
  if (border_.count < kEnoughCells || inside_.count < kEnoughCells) return 0;
  const double excess =
      border_.sum / static_cast<double>(border_.count) - inside_.sum / static_cast<double>(inside_.count);
  return std::max(0.0, excess);  // chunks are cut where there is little to differ
}

}  // namespace cloud_colorizer
