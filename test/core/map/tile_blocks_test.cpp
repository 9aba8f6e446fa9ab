// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/tile_blocks.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

TEST(CubesOfTiles, HoldEachTileOnceAndNoMorePointsThanAsked) {
  ScratchDirectory scratch;
  RecordParams params;
  params.voxel_size = 0, params.min_range = 0, params.max_range = 1000, params.tile_size = 1;
  Recorder recorder(scratch / "r", "map", params);
  Cloud cloud;
  cloud.positions = 30 * Eigen::Matrix3Xd::Random(3, 3000);
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  const Recording recording = recorder.snapshot();
  TileIds all(recording.tiles().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (const std::size_t most : {1UL, 100UL, 100000UL}) {
    std::multiset<std::size_t> seen;
    const std::vector<TileIds> cubes = cubesOfTiles(recording, all, most);
    for (const TileIds& cube : cubes) {
      EXPECT_TRUE(cube.size() == 1 || countPoints(recording.tiles(), cube) <= most);
      seen.insert(cube.begin(), cube.end());
    }
    EXPECT_EQ(seen, std::multiset<std::size_t>(all.begin(), all.end()));
    EXPECT_EQ(cubes.size() == 8, most == 100000);
  }
}

}  // namespace
}  // namespace cloud_colorizer
