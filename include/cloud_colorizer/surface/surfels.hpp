// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Surfels: the small discs that stand for the surface between the points when visibility is decided.
#pragma once

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/zorder.hpp"

namespace cloud_colorizer {

struct SurfelParams {
  int num_neighbors = 16;  ///< points that a neighbourhood must have to give normal and radius; 4 to 100

  void check() const;
};

/// One column an input point.
struct Surfels {
  Eigen::Matrix3Xf normals;  ///< unit, sign arbitrary; zero where the neighbourhood is no plane (poles, leaves)
  Eigen::VectorXf radii;     ///< m; the discs of neighbours just close the surface; negative: of something that moved,
                             ///< which hides and is seen only where a scan of the moment confirms it
  /// m along the normal from the point to the surface through its neighbours: a scanned wall is a slab some
  /// centimetres thick, and its points would hide one another. Empty counts as zeros.
  Eigen::VectorXf offsets;
  /// m, standard deviation by which surfaces through parts of the neighbours would differ: what averaging leaves of the
  /// range noise, the layers that drift of the poses makes, the depth of leaves. Empty counts as zeros.
  Eigen::VectorXf thicknesses{};

  /// The point moved onto the surface.
  Eigen::Vector3f onSurface(Eigen::Index i, const Eigen::Vector3f& point) const {
    return offsets.size() == 0 ? point : Eigen::Vector3f(point + offsets[i] * normals.col(i));
  }
  Points onSurface(PointsRef points) const;  ///< all of them
  /// `count` columns from `first` on. All members have a column for each point.
  Surfels segment(Eigen::Index first, Eigen::Index count) const {
    return {normals.middleCols(first, count), radii.segment(first, count), offsets.segment(first, count),
            thicknesses.segment(first, count)};
  }
  float thickness(Eigen::Index i) const { return thicknesses.size() == 0 ? 0.0F : thicknesses[i]; }
};

/// Surfels of all points, in their frame (3 x n, m). O(n log n). Never NaN, for any finite input; a position given
/// many times counts once. Throws std::invalid_argument for a point that is not finite.
Surfels estimateSurfels(PointsRef points, const SurfelParams& params);

/// A piece of a map: surfels of the first `num_own` points; the others lie around them. Cells of 2^k grid cells are
/// looked at, up to 2^max_level, each with those that touch it. So a surfel does not depend on how the map is cut when
/// pieces lie on one grid and have all points within a largest cell around their own. The grid must hold all points.
Surfels estimateSurfels(PointsRef points, Eigen::Index num_own, const ZOrderGrid& grid, int max_level,
                        const SurfelParams& params);

}  // namespace cloud_colorizer
