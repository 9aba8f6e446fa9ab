// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The surface through the points of a few cells: a plane, bent a little, and how far the points scatter about it.
#pragma once

#include "surface/cell_level.hpp"

namespace cloud_colorizer {

/// Lengths in units of the cell, places relative to the centre of the cell in the middle.
struct Patch {
  enum class Shape { kFew, kNone, kLine, kSurface };
  Shape shape = Shape::kFew;
  float ratio = 1;    ///< of the least to the middle variance: 0 is flat, 1 a ball
  float density = 0;  ///< points over the product of their deviations along the three axes
  float width = 0;    ///< deviation along the middle axis
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  float variance = 0;  ///< along the normal, about the surface
  float extent = 0;    ///< sum of the two variances along the plane
  float spacing = 0;   ///< of the points on the surface
  float bend = 0;      ///< the surface rises above the plane by this times the squared distance along it,
  float rise = 0;      ///< and by this at the mean

  /// From a point to the surface, along the normal.
  float offset(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f d = mean - point;
    const float height = normal.dot(d);
    return height + rise + bend * (d.squaredNorm() - height * height);
  }
  /// Of the bent surface nearest to a point; not yet of length 1.
  Eigen::Vector3f normalAt(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f d = point - mean;
    return normal - 2 * bend * (d - normal.dot(d) * normal);
  }
};

/// The plane of points with these moments.
Patch fitPlane(const Moments& moments);

/// Bends a plane through the neighbouring cells as far as their heights tell it from noise.
void bendPatch(const CellLevel& level, const CellNeighbors& neighbors, Patch& patch);

}  // namespace cloud_colorizer
