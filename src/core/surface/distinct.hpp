// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Points without their repetitions: a map that was given twice has the same surface.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/zorder.hpp"

namespace cloud_colorizer {

/// Each position once, in Z-order.
struct Distinct {
  Points points;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> of_point;  ///< column of each input point
};

inline Distinct distinctPoints(PointsRef points, const ZOrderGrid& grid) {
  const std::vector<std::uint64_t> keys = zorderKeys(points, grid);
  Distinct distinct{Points(3, points.cols()), {}, std::vector<std::uint32_t>(keys.size())};
  distinct.keys.reserve(keys.size());
  for (const std::uint32_t i : zorderSort(keys, 0)) {
    if (distinct.keys.empty() || distinct.keys.back() != keys[i]) {
      distinct.points.col(static_cast<Eigen::Index>(distinct.keys.size())) = points.col(i);
      distinct.keys.push_back(keys[i]);
    }
    distinct.of_point[i] = static_cast<std::uint32_t>(distinct.keys.size() - 1);
  }
  distinct.points.conservativeResize(3, static_cast<Eigen::Index>(distinct.keys.size()));
  return distinct;
}

}  // namespace cloud_colorizer
