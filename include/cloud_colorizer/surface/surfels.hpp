// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Surfels: the small discs that stand for the surface between the points when visibility is decided.
#pragma once

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

struct SurfelParams {
  int num_neighbors = 16;  ///< points in the neighbourhood that gives normal and radius, itself included; 4 to 100

  void check() const;
};

/// One column an input point.
struct Surfels {
  Eigen::Matrix3Xf normals;  ///< unit, sign arbitrary; zero where the neighbourhood is no plane (poles, leaves)
  Eigen::VectorXf radii;     ///< m; the discs of neighbours just close the surface; negative: hides nothing
  /// m along the normal from the point to the surface through its neighbours: a scanned wall is a slab some
  /// centimetres thick, and its points would hide one another. Empty counts as zeros.
  Eigen::VectorXf offsets;

  /// The point moved onto the surface.
  Eigen::Vector3f onSurface(Eigen::Index i, const Eigen::Vector3f& point) const {
    return offsets.size() == 0 ? point : Eigen::Vector3f(point + offsets[i] * normals.col(i));
  }
};

/// Normals, radii and offsets from the nearest neighbours, in the frame of `points` (3 x n, m). O(n log n). Never NaN,
/// for any finite input (duplicates included). Throws std::invalid_argument for a point that is not finite.
Surfels estimateSurfels(PointsRef points, const SurfelParams& params);

}  // namespace cloud_colorizer
