// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "base/position_hash.hpp"
#include "base/progress.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr double kSamplesPerTile = 4000;
constexpr double kCellsPerReach = 16;  // in max_view_distance: what a camera sees from afar spans several cells

/// Mean over the channels of the logarithm of each view's gain.
std::vector<double> logGains(const Workspace& work) {
  std::vector<double> logs;
  for (const CorrectedView& view : work.corrections()) {
    const Eigen::ArrayXf& gain = view.exposure.gain;
    logs.push_back(gain.size() > 0 ? static_cast<double>(gain.log().mean()) : 0.0);
  }
  return logs;
}

/// A tile is a whole number of cells, so that every cell has its samples from one tile.
double cellSize(const Workspace& work) {
  const double tile = work.recording().tileSize(), wanted = work.params().depth.max_view_distance / kCellsPerReach;
  return tile / std::max(1.0, std::round(tile / wanted));
}

ToneCells sampleTile(Workspace& work, std::size_t tile, const std::vector<double>& log_gains, double cell) {
  const auto whole = work.surface(tile);
  const double share = kSamplesPerTile / static_cast<double>(whole->size());
  const Surface sample = gatherSurface(*whole, hashedSample(whole->points, share));
  const std::vector<std::size_t> views = work.viewsOf(work.recording().tileBox(tile));
  const auto viewAt = [&](std::size_t k) { return work.observedView(views[k]); };
  const Observations seen =
      observe(sample.points, sample.surfels, views.size(), viewAt, work.params().depth, work.params().observe)
          .observations;
  ToneCells cells;
  for (std::size_t p = 0; p < seen.numPoints(); ++p) {
    double sum = 0, weights = 0;
    for (std::uint32_t k = seen.offsets[p]; k < seen.offsets[p + 1]; ++k) {
      const auto weight = static_cast<double>(seen.weights[k]);
      sum += weight * log_gains[seen.views[k]];
      weights += weight;
    }
    if (!(weights > 0)) continue;
    ToneSum& at = cells[ToneField::cellOf(sample.points.col(static_cast<Index>(p)), cell)];
    at.log_gain += sum / weights;
    at.count += 1;
  }
  return cells;
}

}  // namespace

ToneField makeTone(Workspace& work, const Callbacks& callbacks) {
  const std::vector<double> log_gains = logGains(work);
  const double limit = std::log(work.params().tone.exposure_range);
  const auto isWithin = [limit](double log_gain) { return std::abs(log_gain) <= limit; };
  if (std::all_of(log_gains.begin(), log_gains.end(), isWithin)) return {};

  const double cell = cellSize(work);
  const std::size_t num_tiles = work.recording().tiles().size();
  std::vector<ToneCells> of_tiles(num_tiles);
  ProgressMeter progress(callbacks, "tone", num_tiles);
  parallelFor(work.params().colorize.num_threads, num_tiles, [&](std::size_t tile) {
    of_tiles[tile] = sampleTile(work, tile, log_gains, cell);
    progress.add(1);
  });
  ToneCells all;
  for (ToneCells& cells : of_tiles) {
    for (const auto& [index, sum] : cells) {  // a point on a tile's side may be rounded into its neighbour's cell
      all[index].log_gain += sum.log_gain;
      all[index].count += sum.count;
    }
  }
  return {all, cell, work.params().tone};
}

}  // namespace cloud_colorizer
