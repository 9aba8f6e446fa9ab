// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surface/zorder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace cloud_colorizer {
namespace {

/// The definition, bit by bit.
std::uint64_t interleave(const std::array<std::uint32_t, 3>& cell) {
  std::uint64_t key = 0;
  for (int bit = 0; bit < kZOrderBits; ++bit) {
    for (int axis = 0; axis < 3; ++axis) key |= std::uint64_t{cell[axis] >> bit & 1} << (3 * bit + axis);
  }
  return key;
}

std::array<std::uint32_t, 3> randomCell(std::mt19937& random) {
  std::uniform_int_distribution<std::uint32_t> any(0, (1U << kZOrderBits) - 1);
  return {any(random), any(random), any(random)};
}

Points centerOf(const std::array<std::uint32_t, 3>& cell) {
  Points point(3, 1);
  for (int axis = 0; axis < 3; ++axis) point(axis, 0) = static_cast<float>(cell[axis]) + 0.5F;
  return point;
}

TEST(Zorder, KeysInterleaveTheBitsOfTheCells) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const auto cell = randomCell(random);
    EXPECT_EQ(zorderKeys(centerOf(cell), {Eigen::Vector3f::Zero(), 1.0F}).at(0), interleave(cell));
  }
}

TEST(Zorder, OriginAndCellAreUsed) {
  Points point(3, 1);
  point << -9.75F, 20.3F, 3.0F;
  EXPECT_EQ(zorderKeys(point, {Eigen::Vector3f(-10, 20, 2), 0.25F}).at(0), interleave({1, 1, 4}));
}

TEST(Zorder, GridOfThePointsHoldsThem) {
  for (const float extent : {1e-44F, 1e-30F, 1.F, 1e30F}) {
    for (const int bits : {1, 10, 20}) {
      const Points points = extent * (Points(3, 3) << 0, 1, 0.5F, 0, 0, -0.5F, 0.1F, 0.2F, 0.3F).finished();
      const ZOrderGrid grid = gridOf(points, bits);
      const auto keys = zorderKeys(points, grid);  // throws if one lies outside
      EXPECT_LT(*std::max_element(keys.begin(), keys.end()), std::uint64_t{1} << 3 * (bits + 1)) << extent;
    }
  }
  EXPECT_EQ(zorderKeys(Points::Ones(3, 2), gridOf(Points::Ones(3, 2))), (std::vector<std::uint64_t>{0, 0}));
  EXPECT_GT(gridOf(Points(3, 0)).cell, 0);
  EXPECT_THROW(gridOf(Points::Ones(3, 2), 0), std::invalid_argument);
  EXPECT_THROW(gridOf(Points::Ones(3, 2), 21), std::invalid_argument);
}

TEST(Zorder, PassSortsTheMirroredCoordinates) {
  std::mt19937 random(2);
  std::vector<std::uint64_t> keys;
  std::vector<std::array<std::uint32_t, 3>> cells;
  for (int i = 0; i < 500; ++i) {
    cells.push_back(i % 5 < 3 ? randomCell(random) : cells.back());  // with duplicates
    if (i % 5 == 3)
      cells.back()[i % 3] ^= static_cast<std::uint32_t>(random() % 64);  // and others that differ in the last bits only
    keys.push_back(interleave(cells.back()));
  }
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    std::vector<std::uint64_t> mirrored;
    for (auto cell : cells) {
      if (pass > 0) cell[pass - 1] = (1U << kZOrderBits) - 1 - cell[pass - 1];
      mirrored.push_back(interleave(cell));
    }
    std::vector<std::uint32_t> expected(cells.size());
    std::iota(expected.begin(), expected.end(), 0U);
    std::stable_sort(expected.begin(), expected.end(), [&](auto a, auto b) { return mirrored[a] < mirrored[b]; });
    EXPECT_EQ(zorderSort(keys, zorderMask(pass)), expected) << "pass " << pass;
  }
}

TEST(Zorder, ShiftMovesTheCellsOfAPass) {
  std::mt19937 random(4);
  std::vector<std::array<std::uint32_t, 3>> cells = {{0, 0, 0}, {(1U << kZOrderBits) - 1, 0, 1U << 20}};
  for (int i = 0; i < 200; ++i) cells.push_back(randomCell(random));
  std::vector<std::uint64_t> keys;
  for (const auto& cell : cells) keys.push_back(interleave(cell));
  for (std::uint32_t pass = 0; pass < kMaxPasses; ++pass) {
    std::vector<std::uint64_t> expected;
    for (auto cell : cells) {
      for (auto& coordinate : cell) coordinate = (coordinate + pass * ((1U << 20) / 5)) % (1U << kZOrderBits);
      expected.push_back(interleave(cell));
    }
    EXPECT_EQ(shiftedKeys(keys, static_cast<int>(pass)), expected) << "pass " << pass;
  }
  EXPECT_TRUE(shiftedKeys({}, 1).empty());
  EXPECT_THROW(shiftedKeys(keys, kMaxPasses), std::invalid_argument);
}

TEST(Zorder, PointBeyondTheGridIsRefused) {
  const ZOrderGrid grid{Eigen::Vector3f::Zero(), 0.5F};
  const float end = 0.5F * static_cast<float>(1 << kZOrderBits);
  for (const float bad :
       {-0.001F, end, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (int axis = 0; axis < 3; ++axis) {
      Points point = Points::Ones(3, 1);
      point(axis, 0) = bad;
      EXPECT_THROW(zorderKeys(point, grid), std::out_of_range) << bad;
    }
  }
  EXPECT_NO_THROW(zorderKeys(Points::Constant(3, 1, end - 0.5F), grid));
}

TEST(Zorder, BadGridOrPassIsRefused) {
  EXPECT_THROW(zorderKeys(Points::Ones(3, 1), {Eigen::Vector3f::Zero(), 0.0F}), std::invalid_argument);
  EXPECT_THROW(zorderKeys(Points::Ones(3, 1), {Eigen::Vector3f::Constant(NAN), 1.0F}), std::invalid_argument);
  EXPECT_THROW(zorderMask(-1), std::invalid_argument);
  EXPECT_THROW(zorderMask(kMaxPasses), std::invalid_argument);
}

TEST(Zorder, NoPointsGiveNoKeysAndNoOrder) {
  EXPECT_TRUE(zorderKeys(Points(3, 0), ZOrderGrid{}).empty());
  EXPECT_TRUE(zorderSort({}, 0).empty());
}

}  // namespace
}  // namespace cloud_colorizer
