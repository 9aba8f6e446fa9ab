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
/// kAuto: what the solver is good at, kShared for a factorisation and kOwn else; kOwn where there is no solver.
enum class PassGrids { kAuto, kOwn, kShared };

struct GraphParams {
  int passes = 4;  ///< 1 to 4 Z-order passes
  PassGrids grids = PassGrids::kAuto;

  void check() const;
};

struct Edge {
  std::uint32_t p = 0, q = 0;  ///< p < q
  float weight = 1;            ///< of the edge's term in eq. (3), 0 to 1; an edge of weight 0 is no edge
};

/// Links of neighbours in the Z-orders of params.passes passes, each edge once, ascending by (p, q).
/// O(n).
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
