// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "cloud_colorizer/chunks.hpp"
#include "cloud_colorizer/parallel.hpp"
#include "cloud_colorizer/point_colors.hpp"
#include "cloud_colorizer/tone.hpp"
#include "progress.hpp"
#include "stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Bytes that a point of a chunk takes while it is coloured; measured, rounded up.
constexpr double kBytesPerPoint = 1400;
/// Share of memory_limit for chunks; the rest is for the caches of the workspace.
constexpr double kChunkShare = 0.55;

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

/// What the gains of the alignment did to the brightness of each place.
ToneField toneField(const Workspace& work) {
  const double reach = work.params().depth.max_view_distance / 8;
  std::vector<ViewTone> tones;
  for (std::size_t v = 0; v < work.recording().views().size(); ++v) {
    const CorrectedView& view = work.corrected(v);
    const Eigen::Vector3d ahead = view.map_from_camera * Eigen::Vector3d(0, 0, reach);
    const float gain = view.exposure.gain.size() > 0 ? std::exp(view.exposure.gain.log().mean()) : 1;
    tones.push_back({ahead.cast<float>(), gain});
  }
  return {std::move(tones), reach, work.params().tone};
}

/// Writes the colours of the core's tiles; column k of `colors` belongs to gathered point order[k].
void writeCore(const Workspace& work, const Chunk& chunk, const std::vector<Index>& order, const ToneField& tone,
               const Points& points, const PointColors& colors, const std::vector<Unseen>& unseen) {
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
    tone.apply(tileBox(work.recording(), tile), gatherColumns(points, columns), out.values);
    out.values = out.values.cwiseMax(0.F).cwiseMin(255.F);
    for (std::size_t i = 0; i < count; ++i) {
      const Index k = columns[i];
      out.count[i] = static_cast<std::uint16_t>(std::min(colors.count[k], 65535));
      out.stddev[i] = colors.stddev[k];
      out.unseen[i] = unseen[static_cast<std::size_t>(k)];
    }
    work.writeColors(tile, out);
  }
}

void colorChunk(Workspace& work, const Chunk& chunk, const ZOrderGrid& grid, const ToneField& tone) {
  Surface surface = gatherChunk(work, chunk);
  // In Z-order, what is near in space is near in memory: several times faster gradients and factorisation.
  const auto sorted = zorderSort(zorderKeys(surface.points, grid), zorderMask(0));
  const std::vector<Index> order(sorted.begin(), sorted.end());
  surface = gatherSurface(surface, order);

  std::vector<std::size_t> views;
  for (std::size_t view = 0; view < work.recording().views().size(); ++view) {
    if (work.mayObserve(view, chunk.box_with_halo)) views.push_back(view);
  }
  const auto viewAt = [&](std::size_t k) { return work.observedView(views[k]); };
  const Params& params = work.params();
  const ObserveResult seen =
      observe(surface.points, surface.surfels, views.size(), viewAt, params.depth, params.observe);
  PointColors colors = colorPoints(surface.points, seen.observations, grid, params);
  // Without a view nothing tells the number of channels.
  if (views.empty()) colors.values = Values::Zero(3, surface.size());
  writeCore(work, chunk, order, tone, surface.points, colors, seen.unseen);
}

}  // namespace

void colorChunks(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const Params& params = work.params();
  std::vector<Chunk> chunks = planChunks(recording.tiles(), recording.tileSize(), params.chunks);
  // Large ones first, so that no thread is left with one at the end.
  std::stable_sort(chunks.begin(), chunks.end(),
                   [](const Chunk& a, const Chunk& b) { return a.num_core_points > b.num_core_points; });
  const ZOrderGrid grid = globalGrid(recording);
  const ToneField tone = toneField(work);

  const std::size_t largest = chunks.empty() ? 1 : std::max<std::size_t>(1, chunks.front().num_core_points);
  const double halo_factor = std::pow(1 + 2 * params.chunks.overlap, 2);  // points lie on surfaces
  const double chunk_bytes = static_cast<double>(largest) * halo_factor * kBytesPerPoint;
  const double room = params.colorize.memory_limit * 1e6 * kChunkShare / chunk_bytes;
  const int num_threads = std::min(resolveNumThreads(params.colorize.num_threads), std::max(1, static_cast<int>(room)));

  ProgressMeter progress(callbacks, "colour", recording.numPoints());
  parallelFor(num_threads, chunks.size(), [&](std::size_t c) {
    const auto& tiles = chunks[c].core_tiles;
    const bool todo = !std::all_of(tiles.begin(), tiles.end(), [&](std::size_t tile) { return work.hasColors(tile); });
    if (todo) colorChunk(work, chunks[c], grid, tone);
    progress.add(chunks[c].num_core_points, todo);
  });
}

}  // namespace cloud_colorizer
