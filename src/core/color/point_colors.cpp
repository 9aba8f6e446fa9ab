// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/point_colors.hpp"

#include <utility>
#include <vector>

#include "base/columns.hpp"
#include "color/solve.hpp"
#include "visibility/seen_points.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Views disagree by about this much for reasons that are no fault of any of them (noise, small misregistration).
constexpr float kMinRobustScale = 6;

Fused fuse(const Observations& observations, Method method) {
  switch (method) {
    case Method::kClosest:
      return fuseClosest(observations);
    case Method::kMedian:
      return fuseMedian(observations);
    case Method::kMean:
    case Method::kPaper:
      return fuseMean(observations);
    case Method::kDefault:
      break;
  }
  return fuseRobust(observations, kMinRobustScale);
}

}  // namespace

Fused colorPoints(PointsRef points, Observations observations, const ZOrderGrid& grid, Method method,
                  const GraphParams& graph, SystemParams system) {
  Fused fused = fuse(observations, method);
  if (method != Method::kPaper && method != Method::kDefault) return fused;
  const std::vector<Index> seen = keepSeen(observations);
  if (seen.empty()) return fused;

  const Fused data{gatherColumns(fused.values, seen), gatherColumns(fused.count, seen),
                   gatherColumns(fused.stddev, seen), std::move(fused.observation_weights)};
  if (method == Method::kPaper) system.min_data_weight = 0;
  const Values solved = solveValues(gatherColumns<Points>(points, seen), observations, data, grid, graph, system);
  for (std::size_t k = 0; k < seen.size(); ++k) fused.values.col(seen[k]) = solved.col(static_cast<Index>(k));
  return fused;
}

}  // namespace cloud_colorizer
