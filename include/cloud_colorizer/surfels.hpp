// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Surfels: the small discs that stand for the surface between the points when visibility is decided.
#pragma once

#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

struct SurfelParams {
  int num_neighbors = 12;  ///< points in the neighbourhood that gives normal and radius

  void check() const;
};

/// One column an input point.
struct Surfels {
  Eigen::Matrix3Xf normals;  ///< unit, sign arbitrary; zero where the neighbourhood is no plane (poles, leaves)
  Eigen::VectorXf radii;     ///< m; the discs of neighbours just close the surface
};

/// Normals and radii from the nearest neighbours. O(n log n). Never NaN, for any finite input (duplicates included).
Surfels estimateSurfels(PointsRef points, const SurfelParams& params);

}  // namespace cloud_colorizer
