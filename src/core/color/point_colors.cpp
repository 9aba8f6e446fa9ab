// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/point_colors.hpp"

#include <utility>
#include <vector>

#include "base/columns.hpp"
#include "cloud_colorizer/color/solve.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Views disagree by about this much for reasons that are no fault of any of them (noise, small misregistration).
constexpr float kMinRobustScale = 6;

std::vector<Index> seenPoints(const Observations& observations) {
  std::vector<Index> seen;
  for (std::size_t p = 0; p < observations.numPoints(); ++p) {
    if (observations.offsets[p + 1] > observations.offsets[p]) seen.push_back(static_cast<Index>(p));
  }
  return seen;
}

/// Takes out the rows of points that have no observations; nothing else moves.
void dropUnseen(Observations& observations, const std::vector<Index>& seen) {
  std::vector<std::uint32_t> offsets(1, 0);
  offsets.reserve(seen.size() + 1);
  for (const Index p : seen) offsets.push_back(observations.offsets[static_cast<std::size_t>(p) + 1]);
  observations.offsets = std::move(offsets);
}

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

Fused colorPoints(PointsRef points, Observations observations, const ZOrderGrid& grid, Method method, GraphParams graph,
                  SystemParams system) {
  Fused fused = fuse(observations, method);
  const std::vector<Index> seen = seenPoints(observations);
  if ((method != Method::kPaper && method != Method::kDefault) || seen.empty()) return fused;

  const Fused data{gatherColumns(fused.values, seen), gatherColumns(fused.count, seen),
                   gatherColumns(fused.stddev, seen), std::move(fused.observation_weights)};
  if (method == Method::kPaper) {
    graph.edge_length_ratio = 0;
    system.min_data_weight = 0;
  }
  dropUnseen(observations, seen);
  const Values solved = solveValues(gatherColumns<Points>(points, seen), observations, data, grid, graph, system);
  for (std::size_t k = 0; k < seen.size(); ++k) fused.values.col(seen[k]) = solved.col(static_cast<Index>(k));
  return fused;
}

}  // namespace cloud_colorizer
