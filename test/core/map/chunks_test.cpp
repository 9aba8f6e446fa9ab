// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/chunks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace cloud_colorizer {
namespace {

/// A street of tiles along x, from negative to positive indices, thin in z.
std::vector<Tile> streetTiles(std::size_t points_per_tile) {
  std::vector<Tile> tiles;
  for (std::int32_t x = -5; x < 6; ++x) {
    for (std::int32_t y = -2; y < 2; ++y) tiles.push_back({{x, y, 0}, points_per_tile});
  }
  return tiles;
}

ChunkParams smallChunks(int max_points, double overlap) {
  ChunkParams params;
  params.max_chunk_points = max_points;
  params.overlap = overlap;
  return params;
}

TEST(Chunks, NoTilesGiveNoChunks) {
  EXPECT_TRUE(planChunks({}, 10, {}).empty());
}

TEST(Chunks, EveryTileIsInExactlyOneCore) {
  const auto tiles = streetTiles(1000);
  std::multiset<std::size_t> seen;
  for (const Chunk& chunk : planChunks(tiles, 10, smallChunks(5000, 0.1))) {
    seen.insert(chunk.core_tiles.begin(), chunk.core_tiles.end());
  }
  ASSERT_EQ(seen.size(), tiles.size());
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) EXPECT_EQ(seen.count(tile), 1U);
}

TEST(Chunks, CoreHasNoMorePointsThanAllowedUnlessItIsOneTile) {
  for (const Chunk& chunk : planChunks(streetTiles(1000), 10, smallChunks(5000, 0.1))) {
    EXPECT_LE(chunk.num_core_points, 5000U);
  }
  for (const Chunk& chunk : planChunks(streetTiles(9000), 10, smallChunks(5000, 0.1))) {
    EXPECT_EQ(chunk.core_tiles.size(), 1U);
  }
}

TEST(Chunks, SparsePlacesDoNotTakeADensePlaceIntoTheirHalo) {
  // Fields on both sides of a dense street, that would fit into a few large cubes.
  std::vector<Tile> tiles;
  for (std::int32_t x = -32; x < 32; ++x) {
    for (std::int32_t y = -32; y < 32; ++y) tiles.push_back({{x, y, 0}, y == 0 ? 4000U : 1U});
  }
  const ChunkParams params = smallChunks(5000, 0.25);
  std::size_t num_tiles = 0, num_points = 0;
  double with_halo = 0;
  for (const Chunk& chunk : planChunks(tiles, 10, params)) {
    num_tiles += chunk.core_tiles.size();
    num_points += chunk.num_core_points;
    with_halo += chunk.num_points_with_halo;
    EXPECT_LE(chunk.num_points_with_halo, params.maxPointsWithHalo());
  }
  EXPECT_EQ(num_tiles, tiles.size());
  EXPECT_LT(with_halo, 1.6 * static_cast<double>(num_points));
}

TEST(Chunks, AFloorIsNotCutAlong) {
  // A road at z = 0: half of its points are above, half below.
  std::vector<Tile> tiles;
  for (std::int32_t x = 0; x < 32; ++x) {
    for (std::int32_t z = -1; z < 1; ++z) tiles.push_back({{x, 0, z}, 1000});
  }
  const auto chunks = planChunks(tiles, 10, smallChunks(5000, 0.1));
  EXPECT_GE(chunks.size(), 13U);
  for (const Chunk& chunk : chunks) EXPECT_EQ(chunk.high[2] - chunk.low[2], 2);
}

TEST(Chunks, PointsWithHaloAreThoseInTheBox) {
  const std::vector<Tile> tiles = {{{0, 0, 0}, 1000}, {{1, 0, 0}, 400}};
  const auto chunks = planChunks(tiles, 10, smallChunks(1000, 0.25));
  ASSERT_EQ(chunks.size(), 2U);
  EXPECT_DOUBLE_EQ(chunks[0].num_points_with_halo, 1000 + 100);
  EXPECT_DOUBLE_EQ(chunks[1].num_points_with_halo, 400 + 250);
}

TEST(Chunks, FarApartTilesDoNotMakeManyChunks) {
  const std::vector<Tile> tiles = {{{-1000000, 0, 0}, 10}, {{1000000, 5, 0}, 10}};
  EXPECT_LE(planChunks(tiles, 1, smallChunks(1000, 0.1)).size(), 2U);
}

TEST(Chunks, HaloHoldsExactlyTheTilesThatItsBoxTouches) {
  const auto tiles = streetTiles(1000);
  for (const Chunk& chunk : planChunks(tiles, 10, smallChunks(5000, 0.25))) {
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
      const Eigen::Vector3f low(10.F * static_cast<float>(tiles[tile].index[0]),
                                10.F * static_cast<float>(tiles[tile].index[1]), 0.F);
      const Eigen::AlignedBox3f box(low, low + Eigen::Vector3f::Constant(10));
      const bool touched = chunk.box_with_halo.intersection(box).sizes().minCoeff() > 0;
      const bool listed = std::count(chunk.core_tiles.begin(), chunk.core_tiles.end(), tile) +
                              std::count(chunk.halo_tiles.begin(), chunk.halo_tiles.end(), tile) ==
                          1;
      EXPECT_EQ(touched, listed);
    }
  }
}

TEST(Chunks, WithoutOverlapThereIsNoHalo) {
  for (const Chunk& chunk : planChunks(streetTiles(1000), 10, smallChunks(5000, 0))) {
    EXPECT_TRUE(chunk.halo_tiles.empty());
  }
}

TEST(Chunks, RefusesBadParameters) {
  EXPECT_THROW(planChunks(streetTiles(1), 10, smallChunks(0, 0.1)), std::invalid_argument);
  EXPECT_THROW(planChunks(streetTiles(1), 10, smallChunks(5000, -0.1)), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
