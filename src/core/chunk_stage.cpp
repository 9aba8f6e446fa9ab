// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "cloud_colorizer/chunks.hpp"
#include "cloud_colorizer/parallel.hpp"
#include "cloud_colorizer/point_colors.hpp"
#include "progress.hpp"
#include "stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Bytes that a point of a chunk takes while it is coloured; measured, rounded up.
constexpr double kBytesPerPoint = 1800;
/// Share of memory_limit for chunks; the rest is for the caches of the workspace.
constexpr double kChunkShare = 0.6;

/// The points of a chunk: its core tiles one after the other, then what lies in its halo.
TileSurface gatherSurface(Workspace& work, const Chunk& chunk) {
  std::vector<std::shared_ptr<const TileSurface>> tiles;
  std::vector<std::vector<Index>> columns;  // taken of each tile; empty for a core tile: all
  Index num_points = 0;
  for (const std::size_t tile : chunk.core_tiles) {
    tiles.push_back(work.surface(tile));
    columns.emplace_back();
    num_points += tiles.back()->points.cols();
  }
  for (const std::size_t tile : chunk.halo_tiles) {
    const auto surface = work.surface(tile);
    std::vector<Index> inside;
    for (Index i = 0; i < surface->points.cols(); ++i) {
      if (chunk.box_with_halo.contains(surface->points.col(i))) inside.push_back(i);
    }
    if (inside.empty()) continue;
    num_points += static_cast<Index>(inside.size());
    tiles.push_back(surface);
    columns.push_back(std::move(inside));
  }

  TileSurface all{Points(3, num_points),
                  {Eigen::Matrix3Xf(3, num_points), Eigen::VectorXf(num_points), Eigen::VectorXf(num_points)}};
  Index next = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const bool core = t < chunk.core_tiles.size();
    const Index count = core ? tiles[t]->points.cols() : static_cast<Index>(columns[t].size());
    for (Index k = 0; k < count; ++k, ++next) {
      const Index i = core ? k : columns[t][static_cast<std::size_t>(k)];
      all.points.col(next) = tiles[t]->points.col(i);
      all.surfels.normals.col(next) = tiles[t]->surfels.normals.col(i);
      all.surfels.radii[next] = tiles[t]->surfels.radii[i];
      all.surfels.offsets[next] = tiles[t]->surfels.offsets[i];
    }
  }
  return all;
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

void writeCore(const Workspace& work, const Chunk& chunk, const PointColors& colors,
               const std::vector<Unseen>& unseen) {
  Index begin = 0;
  for (const std::size_t tile : chunk.core_tiles) {
    const auto count = static_cast<Index>(work.recording().tiles()[tile].num_points);
    TileColors out;
    out.values = colors.values.middleCols(begin, count).cwiseMax(0.F).cwiseMin(255.F);
    out.count.resize(static_cast<std::size_t>(count));
    out.stddev.assign(colors.stddev.data() + begin, colors.stddev.data() + begin + count);
    for (Index i = 0; i < count; ++i) {
      out.count[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(std::min(colors.count[begin + i], 65535));
    }
    out.unseen.assign(unseen.begin() + begin, unseen.begin() + begin + count);
    work.writeColors(tile, out);
    begin += count;
  }
}

void colorChunk(Workspace& work, const Chunk& chunk, const ZOrderGrid& grid) {
  const TileSurface surface = gatherSurface(work, chunk);
  std::vector<std::size_t> views;
  for (std::size_t view = 0; view < work.recording().views().size(); ++view) {
    if (work.mayObserve(view, chunk.box_with_halo)) views.push_back(view);
  }
  const auto viewAt = [&](std::size_t k) { return work.observedView(views[k]); };
  const Params& params = work.params();
  ObserveResult seen = observe(surface.points, surface.surfels, views.size(), viewAt, params.depth, params.observe);
  const PointColors colors = colorPoints(surface.points, seen.observations, grid, params);
  writeCore(work, chunk, colors, seen.unseen);
}

}  // namespace

void colorChunks(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const Params& params = work.params();
  const std::vector<Chunk> chunks = planChunks(recording.tiles(), recording.tileSize(), params.chunks);
  const ZOrderGrid grid = globalGrid(recording);

  std::size_t largest = 1;
  for (const Chunk& chunk : chunks) largest = std::max(largest, chunk.num_core_points);
  const double halo_factor = std::pow(1 + 2 * params.chunks.overlap, 2);  // points lie on surfaces
  const double chunk_bytes = static_cast<double>(largest) * halo_factor * kBytesPerPoint;
  const double room = params.colorize.memory_limit * 1e6 * kChunkShare / chunk_bytes;
  const int num_threads = std::min(resolveNumThreads(params.colorize.num_threads), std::max(1, static_cast<int>(room)));

  ProgressMeter progress(callbacks, "colour", recording.numPoints());
  parallelFor(num_threads, chunks.size(), [&](std::size_t c) {
    const auto& tiles = chunks[c].core_tiles;
    const bool todo = !std::all_of(tiles.begin(), tiles.end(), [&](std::size_t tile) { return work.hasColors(tile); });
    if (todo) colorChunk(work, chunks[c], grid);
    progress.add(chunks[c].num_core_points, todo);
  });
}

}  // namespace cloud_colorizer
