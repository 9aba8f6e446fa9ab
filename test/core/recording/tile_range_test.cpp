// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/tile_range.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace cloud_colorizer {
namespace {

TEST(TileRange, HoldsAllThatTouchAndNothingFarther) {
  std::mt19937 random(5);
  std::uniform_int_distribution<std::int32_t> index(-12, 12);
  std::set<TileIndex> indices;
  while (indices.size() < 1500) indices.insert({index(random), index(random), index(random) / 4});
  std::vector<Tile> tiles;
  for (const TileIndex& each : indices) tiles.push_back({each, 1});
  constexpr double kTileSize = 2.5;
  std::uniform_real_distribution<double> place(-40, 40), size(0, 20);
  for (int round = 0; round < 300; ++round) {
    const Eigen::Vector3d low(place(random), place(random), place(random) / 4);
    const Eigen::AlignedBox3d box(low,
                                  Eigen::Vector3d(low + Eigen::Vector3d(size(random), size(random), size(random))));
    const auto found = tilesAround(tiles, kTileSize, box);
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    for (std::size_t id = 0; id < tiles.size(); ++id) {
      const TileIndex& at = tiles[id].index;
      const Eigen::Vector3d corner = kTileSize * Eigen::Vector3d(at[0], at[1], at[2]);
      const Eigen::AlignedBox3d tile(corner, Eigen::Vector3d(corner.array() + kTileSize));
      const bool is_found = std::binary_search(found.begin(), found.end(), id);
      EXPECT_TRUE(is_found || !tile.intersects(box));
      EXPECT_TRUE(!is_found || std::sqrt(tile.squaredExteriorDistance(box)) <= 2 * kTileSize);
    }
  }
}

TEST(TileRange, ABoxBeyondAllIndicesHoldsEverything) {
  const std::vector<Tile> tiles = {{{-2147483647, 0, 3}, 1}, {{0, 0, 0}, 1}, {{2147483646, 5, 5}, 1}};
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(1e12);
  EXPECT_EQ(tilesAround(tiles, 1, {-far, far}), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_TRUE(tilesAround({}, 1, {-far, far}).empty());
}

}  // namespace
}  // namespace cloud_colorizer
