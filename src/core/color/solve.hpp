// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The paper's method on the points of one chunk: graph, gradients, system, solution.
#pragma once

#include <functional>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/fuse.hpp"
#include "cloud_colorizer/color/graph.hpp"
#include "cloud_colorizer/color/system.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// Processor seconds of each stage, as in the paper's Table 2. `assembly` has the data weights too.
struct SolveSeconds {
  double graph = 0, gradients = 0, assembly = 0, factor = 0, solve = 0;

  double total() const { return graph + gradients + assembly + factor + solve; }
};

struct Solution {
  Values values;  ///< m x n, not clamped to the range of a colour
  SolveSeconds seconds;
};

/// Makes a_p of eq. (2) for edges with their weights; may change the data, m x n.
using Anchoring = std::function<Eigen::VectorXf(const std::vector<Edge>& edges, Values& data)>;

/// The values c that minimise E of eq. (1) on a graph. Every point must have a view. `data` is the fused value of each
/// point (v-bar); its observation_weights, if any, weigh the gradients too. Throws as its stages do.
Solution solveOnGraph(OrderedGraph graph, const Observations& observations, const Fused& data,
                      const SystemParams& params, const Anchoring& anchoring);

/// The same on the points' Z-order graph, with dataWeights().
Values solveValues(PointsRef points, const Observations& observations, const Fused& data, const ZOrderGrid& grid,
                   GraphParams graph_params, const SystemParams& system_params);

}  // namespace cloud_colorizer
