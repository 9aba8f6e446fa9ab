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
  float weight = 1;            ///< of the edge's term in eq. (3), 0 to 1; an edge of weight 0 is no edge
};

/// Links of neighbours in the Z-orders of params.passes passes, each edge once, ascending by (p, q).
/// With an edge_length_ratio L, an edge of length l at local spacing s has weight min(1, (L s / l)^2), at least 1e-6,
/// so that the graph stays connected. s is the mean over the edge's two ends of the median length of the end's edges
/// (the shorter of two middle ones), at least grid.cell.
///
/// All passes at once in O(n) after one sort: a block of the grid's binary tree is one run of points in every pass, so
/// only where a pass enters and leaves it matters. Two points meet in one block only, so duplicates are local to it.
std::vector<Edge> zorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params);

/// The same graph, and an order of elimination for its matrix that costs nothing: points by the block that their last
/// edge is in, inner blocks first. A pass enters and leaves a block once, so at most 8 points of a block have edges out
/// of it, and the factor has few entries a point whatever n is; no search for an ordering (AMD) is needed.
struct OrderedGraph {
  std::vector<Edge> edges;
  std::vector<int> elimination_order;  ///< every point once, first to be eliminated first
};
OrderedGraph orderedZorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params);

/// Label of the connected component of every node, 0-based in order of the smallest node. Edges of weight 0 do not
/// connect. Throws std::invalid_argument if an edge names a node that is not there.
std::vector<std::uint32_t> connectedComponents(std::size_t num_points, const std::vector<Edge>& edges);

}  // namespace cloud_colorizer
