// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Z-order (Morton) keys on one grid for the whole map, and the orders of the mirrored passes.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// 21 bits an axis: at a cell of 1 cm the grid spans 20.9 km.
constexpr int kZOrderBits = 21;

struct ZOrderGrid {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();  ///< m, lower corner
  float cell = 0.01F;                                ///< m, > 0
};

/// A grid of 2^bits cells an axis with the points in it. Throws std::invalid_argument unless bits is from 1 to 20.
ZOrderGrid gridOf(PointsRef points, int bits = 20);

/// Key of every point: bits x0 y0 z0 x1 y1 z1 ... from the lowest. Throws std::out_of_range, with the point, beyond
/// the grid and for NaN, std::invalid_argument for a grid that is not finite.
std::vector<std::uint64_t> zorderKeys(PointsRef points, const ZOrderGrid& grid);

/// Passes in the order of the paper: (x,y,z), (-x,y,z), (x,-y,z), (x,y,-z). Mirroring an axis inverts its bits, so the
/// key of a pass is `key ^ zorderMask(pass)`. Throws std::invalid_argument for another pass.
constexpr int kMaxPasses = 4;
std::uint64_t zorderMask(int pass);

/// Keys on a grid of each pass' own, shifted by pass / 5 of 2^20 cells along every axis (modulo 2^21): two points that
/// a border between blocks parts in one pass are in one block in another, whatever the size of the blocks. T. M. Chan,
/// "Approximate nearest neighbor queries revisited", Discrete & Computational Geometry 20, 1998. A cube of 2^20 cells,
/// as gridOf makes it, stays together. Throws std::invalid_argument for another pass.
std::vector<std::uint64_t> shiftedKeys(const std::vector<std::uint64_t>& keys, int pass);

/// Indices by ascending `key ^ mask`; equal keys by ascending index. A radix sort, O(n) but for points that lie much
/// closer together than the others. Throws std::out_of_range for 2^32 keys or more.
std::vector<std::uint32_t> zorderSort(const std::vector<std::uint64_t>& keys, std::uint64_t mask);

}  // namespace cloud_colorizer
