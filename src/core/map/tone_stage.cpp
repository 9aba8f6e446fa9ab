// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/stages.hpp"
#include "map/tile_blocks.hpp"

namespace cloud_colorizer {
namespace {

/// Of each view, mean over the channels of the logarithm of its gain.
std::vector<float> logGains(const std::vector<CorrectedView>& views) {
  std::vector<float> logs;
  for (const CorrectedView& view : views) {
    const Eigen::ArrayXf& gain = view.exposure.gain;
    logs.push_back(gain.size() > 0 ? gain.log().mean() : 0.F);
  }
  return logs;
}

}  // namespace

double toneCellSize(const Recording& recording) {
  constexpr int kCellsPerBlock = 8;  // a whole number a tile, so that every cell has its points from one
  return blockSize(recording) / kCellsPerBlock;
}

double sheenCellSize(const Recording& recording) {
  constexpr double kVoxels = 20, kCellsOfTile = 4;  // a tile of a map from files has some 6000 points
  return recording.voxelSize() > 0 ? kVoxels * recording.voxelSize() : recording.tileSize() / kCellsOfTile;
}

ToneField makeTone(const Workspace& work) {
  ToneCells all;
  for (std::size_t tile = 0; tile < work.recording().tiles().size(); ++tile) {
    // A point on a tile's side may be rounded into its neighbour's cell.
    addCells(work.files().readViews(tile).tone, all);
  }
  return {all, logGains(work.corrections()), toneCellSize(work.recording()), work.params().colorize.tone};
}

}  // namespace cloud_colorizer
