// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Chance that is a function of the point, so that every chunk and every thread draws the same lots.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/random.hpp"
#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// In [0, 1), uniform over positions; a hash (splitmix64) of the three float bit patterns.
inline double unitHash(const Eigen::Vector3f& point) {
  std::uint64_t hash = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::uint32_t bits = 0;
    const float coordinate = point[axis] + 0.0F;  // -0 becomes +0
    std::memcpy(&bits, &coordinate, sizeof(bits));
    hash = mixBits(hash ^ bits);
  }
  return static_cast<double>(hash >> 11U) * 0x1p-53;
}

/// About a share of the points, the same ones whatever other points are there: indices of columns.
inline std::vector<Eigen::Index> hashedSample(PointsRef points, double share) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (unitHash(points.col(i)) < share) columns.push_back(i);
  }
  return columns;
}

}  // namespace cloud_colorizer
