// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Chunks: blocks of tiles that are coloured one by one, each with a halo so that they fit together without a seam.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

struct ChunkParams {
  int max_chunk_points = 200000;  ///< a chunk is split until its core has no more points (or is one tile)
  double overlap = 0.05;          ///< halo on every side, as a share of the chunk's side (omega of the paper)

  void check() const;
  /// What a full core has with its halo where points lie on one flat surface; a chunk is split until it has no more.
  double maxPointsWithHalo() const;
};

struct Chunk {
  TileIndex low{}, high{};              ///< the core is the box of tiles from low to before high
  std::vector<std::size_t> core_tiles;  ///< into Recording::tiles(), ascending
  std::vector<std::size_t> halo_tiles;  ///< further tiles that the halo touches, ascending
  Eigen::AlignedBox3f box_with_halo;    ///< m, relative to the origin
  std::size_t num_core_points = 0;
  double num_points_with_halo = 0;  ///< as if the points of a tile were spread evenly
};

/// Boxes of tiles, smaller where there are more points (a k-d tree over tiles). A box is cut where the fewest points
/// lie beside the cut, as these are in the halo of the other side: across streets and walls and not along them. Every
/// tile is in exactly one core. Neighbours in space are near in the list. The side of a chunk, for its halo, is the
/// second longest of its box.
std::vector<Chunk> planChunks(const std::vector<Tile>& tiles, double tile_size, const ChunkParams& params);

}  // namespace cloud_colorizer
