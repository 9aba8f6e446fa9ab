// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface/thinned.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace cloud_colorizer {
namespace {

constexpr float kSide = 1;  // m, of a square of points
const ZOrderGrid kGrid{Eigen::Vector3f::Constant(-0.5F), std::ldexp(kSide, -19)};

Surface squareOf(Eigen::Index count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> side(0, kSide);
  Surface surface{Points::Zero(3, count),
                  {Eigen::Matrix3Xf::Zero(3, count), Eigen::VectorXf::Constant(count, 0.01F),
                   Eigen::VectorXf::Zero(count), Eigen::VectorXf::Zero(count)}};
  for (Eigen::Index i = 0; i < count; ++i) surface.points.col(i) << side(random), side(random), 0;
  return surface;
}

std::set<std::array<int, 2>> cellsOf(const Points& points, float cell) {
  std::set<std::array<int, 2>> cells;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Array2f at = ((points.col(i) - kGrid.origin).head<2>().array() / cell).floor();
    cells.insert({static_cast<int>(at.x()), static_cast<int>(at.y())});
  }
  return cells;
}

TEST(ThinSurface, LeavesOnePointInEachCell) {
  const Surface surface = squareOf(100000);  // 3 mm apart
  const auto levels = thinSurface(surface, kGrid);
  ASSERT_GE(levels.size(), 3U);
  Eigen::Index last = surface.size();
  for (const ThinnedSurface& level : levels) {
    EXPECT_LE(2 * level.surface.size(), last);
    last = level.surface.size();
    EXPECT_EQ(cellsOf(level.surface.points, level.cell).size(), static_cast<std::size_t>(last));
    EXPECT_EQ(cellsOf(level.surface.points, level.cell), cellsOf(surface.points, level.cell));
  }
  EXPECT_GT(levels.back().cell, 0.05F);
}

TEST(ThinSurface, WhatIsSparserThanTheCellsStaysWhole) {
  for (const ThinnedSurface& level : thinSurface(squareOf(100), kGrid)) EXPECT_GT(level.cell, 0.02F);
  EXPECT_TRUE(thinSurface(squareOf(0), kGrid).empty());
}

TEST(ThinSurface, WhatMovedDoesNotTakeThePlaceOfWhatStands) {
  Surface surface = squareOf(10000);
  for (Eigen::Index i = 0; i < surface.size(); i += 2) surface.surfels.radii[i] = -0.01F;
  const Surface coarse = thinSurface(surface, kGrid).front().surface;
  const auto moved = (coarse.surfels.radii.array() < 0).count();
  EXPECT_EQ(2 * moved, coarse.size());
}

}  // namespace
}  // namespace cloud_colorizer
