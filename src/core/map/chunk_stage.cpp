// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "cloud_colorizer/map/chunks.hpp"
#include "map/fingerprint.hpp"
#include "map/memory_budget.hpp"
#include "map/memory_plan.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// The points of a chunk: its core tiles one after the other, then what lies in its halo.
Surface gatherChunk(Workspace& work, const Chunk& chunk) {
  std::vector<Surface> parts;
  for (const std::size_t tile : chunk.core_tiles) parts.push_back(*work.surface(tile));
  for (const std::size_t tile : chunk.halo_tiles) {
    const auto surface = work.surface(tile);
    std::vector<Index> inside;
    for (Index i = 0; i < surface->size(); ++i) {
      if (chunk.box_with_halo.contains(surface->points.col(i))) inside.push_back(i);
    }
    if (!inside.empty()) parts.push_back(gatherSurface(*surface, inside));
  }
  return concatenate(parts);
}

/// One grid for the whole map, so that a point in two chunks has the same place in the order.
ZOrderGrid globalGrid(const Recording& recording) {
  const double tile_size = recording.tileSize();
  Eigen::AlignedBox3d box;
  for (const Tile& tile : recording.tiles()) {
    const Eigen::Vector3d low = Eigen::Vector3d(tile.index[0], tile.index[1], tile.index[2]) * tile_size;
    box.extend(low).extend(low + Eigen::Vector3d::Constant(tile_size));
  }
  const double extent = box.sizes().maxCoeff() + 2 * tile_size;
  ZOrderGrid grid;
  grid.origin = (box.min() - Eigen::Vector3d::Constant(tile_size)).cast<float>();
  grid.cell = static_cast<float>(std::ldexp(extent, -kZOrderBits + 1));
  return grid;
}

/// Writes the colours of the core's tiles; column k of `colors` belongs to gathered point order[k].
void writeCore(const Workspace& work, const Chunk& chunk, const std::vector<Index>& order, const ToneField& tone,
               const Points& points, const Fused& colors, const std::vector<Unseen>& unseen) {
  std::vector<Index> column_of(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) column_of[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  std::size_t gathered = 0;
  for (const std::size_t tile : chunk.core_tiles) {
    const std::size_t count = work.recording().tiles()[tile].num_points;
    TileColors out{Values(3, static_cast<Index>(count)), std::vector<std::uint16_t>(count), std::vector<float>(count),
                   std::vector<Unseen>(count)};
    const std::vector<Index> columns(column_of.begin() + static_cast<std::ptrdiff_t>(gathered),
                                     column_of.begin() + static_cast<std::ptrdiff_t>(gathered + count));
    gathered += count;
    out.values = gatherColumns(colors.values, columns);
    tone.apply(gatherColumns(points, columns), out.values);
    out.values = out.values.cwiseMax(0.F).cwiseMin(255.F);
    for (std::size_t i = 0; i < count; ++i) {
      const Index k = columns[i];
      out.count[i] = static_cast<std::uint16_t>(std::min(colors.count[k], 65535));
      out.stddev[i] = colors.stddev[k];
      out.unseen[i] = unseen[static_cast<std::size_t>(k)];
    }
    work.files().writeColors(tile, out);
  }
}

void colorChunk(Workspace& work, const Chunk& chunk, const ZOrderGrid& grid, const ToneField& tone) {
  Surface surface = gatherChunk(work, chunk);
  // In Z-order, what is near in space is near in memory: several times faster gradients and factorisation.
  const auto sorted = zorderSort(zorderKeys(surface.points, grid), zorderMask(0));
  const std::vector<Index> order(sorted.begin(), sorted.end());
  surface = gatherSurface(surface, order);

  const std::vector<std::size_t> views = work.viewsOf(chunk.box_with_halo);
  const auto viewAt = [&](std::size_t k) { return work.observedView(views[k]); };
  const Params& params = work.params();
  ObserveResult seen = observe(surface.points, surface.surfels, views.size(), viewAt, params.depth, params.observe);
  Fused colors = colorPoints(surface.points, std::move(seen.observations), grid, params.colorize.method, params.graph,
                             params.system);
  // Without a view nothing tells the number of channels.
  if (views.empty()) colors.values = Values::Zero(3, surface.size());
  writeCore(work, chunk, order, tone, surface.points, colors, seen.unseen);
}

}  // namespace

void colorChunks(Workspace& work, const ToneField& tone, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const Params& params = work.params();
  std::vector<Chunk> chunks = planChunks(recording.tiles(), recording.tileSize(), params.chunks);
  // Large ones first, so that no thread is left with one at the end.
  std::stable_sort(chunks.begin(), chunks.end(),
                   [](const Chunk& a, const Chunk& b) { return a.num_points_with_halo > b.num_points_with_halo; });
  const ZOrderGrid grid = globalGrid(recording);

  const DerivedFiles& files = work.files();
  files.claim(kColorsFolder, colorsKey(recording, params, work.damagedViews(), work.corrections()));
  MemoryBudget memory(static_cast<double>(MemoryPlan(params.colorize.memory_limit).chunks()));
  ProgressMeter progress(callbacks, "colour", recording.numPoints());
  parallelFor(params.colorize.num_threads, chunks.size(), [&](std::size_t c) {
    const auto& tiles = chunks[c].core_tiles;
    const bool todo = !std::all_of(tiles.begin(), tiles.end(), [&](std::size_t tile) { return files.hasColors(tile); });
    if (todo) {
      const MemoryBudget::Share share(memory, MemoryPlan::chunkBytes(chunks[c].num_points_with_halo));
      colorChunk(work, chunks[c], grid, tone);
    }
    progress.add(chunks[c].num_core_points, todo);
  });
}

}  // namespace cloud_colorizer
