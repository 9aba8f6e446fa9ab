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
  double overlap = 0.1;           ///< halo on every side, as a share of the chunk's side (omega of the paper)

  void check() const;
  /// What a full core has with its halo where points lie on one flat surface; a chunk is split until it has no more.
  double maxPointsWithHalo() const;
};

struct Chunk {
  TileIndex index{};                    ///< lowest tile of the cube of `side` tiles
  std::int32_t side = 1;                ///< tiles
  std::vector<std::size_t> core_tiles;  ///< into Recording::tiles(), ascending
  std::vector<std::size_t> halo_tiles;  ///< further tiles that the halo touches, ascending
  Eigen::AlignedBox3f box_with_halo;    ///< m, relative to the origin
  std::size_t num_core_points = 0;
  double num_points_with_halo = 0;  ///< as if the points of a tile were spread evenly
};

/// A cubic grid that is finer where there are more points (octree over tiles). Every tile is in exactly one core.
std::vector<Chunk> planChunks(const std::vector<Tile>& tiles, double tile_size, const ChunkParams& params);

}  // namespace cloud_colorizer
