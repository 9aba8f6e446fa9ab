// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The graph N of eq. (3): who is whose neighbour.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/zorder.hpp"

namespace cloud_colorizer {

/// kOwn: the passes have a grid each, mirrored and shifted (shiftedKeys). Edges cross the borders of each other's
/// blocks, so differences of exposure spread further over the surface; solved by conjugate gradients. kShared: the
/// passes mirror one grid, as if the paper's cube had a power of two cells. All have the same blocks, which few edges
/// leave: nearly one-dimensional, so that a factorisation is cheap and exact.
enum class PassGrids { kOwn, kShared };

struct GraphParams {
  int passes = 4;                ///< 1 to 4 Z-order passes
  double edge_length_ratio = 0;  ///< edges longer than this many local spacings count less; 0: all count alike
  PassGrids grids = PassGrids::kOwn;

  void check() const;
};

struct Edge {
  std::uint32_t p = 0, q = 0;  ///< p < q
  float weight = 1;            ///< of the edge's term in eq. (3), 0 to 1; an edge of weight 0 is no edge
};

/// Links of neighbours in the Z-orders of params.passes passes, each edge once, ascending by (p, q).
/// With an edge_length_ratio L, an edge of length l at local spacing s has weight min(1, (L s / l)^2), at least 1e-6,
/// so that the graph stays connected. s is the mean over the edge's two ends of the median length of the end's edges
/// (the shorter of two middle ones), at least grid.cell. O(n).
std::vector<Edge> zorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params);

/// The same graph, and for shared grids an order of elimination with which the factor of its matrix has few entries.
struct OrderedGraph {
  std::vector<Edge> edges;
  std::vector<int> elimination_order;  ///< every point once, first to be eliminated first; empty: none is known
};
OrderedGraph orderedZorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params);

/// Label of the connected component of every node, 0-based in order of the smallest node. Edges of weight 0 do not
/// connect. Throws std::invalid_argument if an edge names a node that is not there.
std::vector<std::uint32_t> connectedComponents(std::size_t num_points, const std::vector<Edge>& edges);

}  // namespace cloud_colorizer
