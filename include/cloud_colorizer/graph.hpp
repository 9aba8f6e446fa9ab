// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The graph N of eq. (3): who is whose neighbour.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/types.hpp"
#include "cloud_colorizer/zorder.hpp"

namespace cloud_colorizer {

struct GraphParams {
  int passes = 4;                ///< 1 to 4 Z-order passes
  double edge_length_ratio = 0;  ///< edges longer than this many local spacings count less; 0: all count alike

  void check() const;
};

struct Edge {
  std::uint32_t p = 0, q = 0;  ///< p < q
  float weight = 1;            ///< of the edge's term in eq. (3), 0 to 1
};

/// Links of neighbours in the Z-orders of params.passes passes, each edge once, ascending by (p, q).
/// With an edge_length_ratio L, an edge of length l at local spacing s (median length of its ends' edges) has weight
/// min(1, (L s / l)^2): never zero, so the graph stays connected.
std::vector<Edge> zorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params);

/// Label of the connected component of every node, 0-based in order of the smallest node.
std::vector<std::uint32_t> connectedComponents(std::size_t num_points, const std::vector<Edge>& edges);

}  // namespace cloud_colorizer
