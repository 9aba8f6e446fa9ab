// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Nearest neighbours and the graphs that the paper compares with. Delaunay needs CGAL when the package is built;
/// without it, the function throws std::runtime_error that says so.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/graph.hpp"

namespace cloud_colorizer {

struct Neighbor {
  std::uint32_t index = 0;
  float distance = 0;  ///< m
};
/// For every query the nearest of the points. Throws std::invalid_argument when there are queries and no points.
std::vector<Neighbor> nearestNeighbors(const Points& points, const Points& queries);

/// Every point linked with its k nearest ones, each edge once, ascending by (p, q).
std::vector<Edge> knnGraph(const Points& points, int k);

bool hasDelaunay();
/// Edges of the 3-D Delaunay triangulation, each once, ascending by (p, q). Of equal points only one has edges.
std::vector<Edge> delaunayGraph(PointsRef points);

}  // namespace cloud_colorizer
