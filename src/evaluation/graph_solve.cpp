// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <utility>

#include "base/stop_watch.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/methods.hpp"
#include "evaluation/neighbors.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// The random anchors without the rule that every part gets one: as if all points were one part.
Eigen::VectorXf randomAnchors(PointsRef points, const Fused& data, const SystemParams& params) {
  std::vector<Edge> chain;
  for (std::uint32_t p = 0; p + 1 < points.cols(); ++p) chain.push_back({p, p + 1, 1});
  return dataWeights(points, data, chain, params);
}

/// Last point of every part that has no anchor; adds up the size of those parts.
std::vector<Index> freePoints(const Eigen::VectorXf& anchors, const std::vector<Edge>& edges, double* share) {
  const auto num_points = static_cast<std::size_t>(anchors.size());
  const std::vector<std::uint32_t> labels = connectedComponents(num_points, edges);
  const std::size_t num_parts = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end()) + 1UL;
  std::vector<std::uint8_t> anchored(num_parts, 0);
  std::vector<std::size_t> size(num_parts, 0), last(num_parts, 0);
  for (std::size_t p = 0; p < num_points; ++p) {
    ++size[labels[p]];
    last[labels[p]] = p;
    if (anchors[static_cast<Index>(p)] > 0.5F) anchored[labels[p]] = 1;
  }
  std::vector<Index> points;
  std::size_t count = 0;
  for (std::size_t part = 0; part < num_parts; ++part) {
    if (anchored[part]) continue;
    points.push_back(static_cast<Index>(last[part]));
    count += size[part];
  }
  *share = num_points == 0 ? 0 : static_cast<double>(count) / static_cast<double>(num_points);
  return points;
}

}  // namespace

OrderedGraph buildGraph(const std::string& graph, const Points& points) {
  if (graph == "DT") return {delaunayGraph(points), {}};
  const int number = std::atoi(graph.c_str());
  if (endsWith(graph, "-NN") && number > 0) return {knnGraph(points, number), {}};
  const bool shared = endsWith(graph, "-pass shared");
  require<std::invalid_argument>((endsWith(graph, "-pass") || shared) && number > 0, "unknown graph '", graph,
                                 "'; known are 1-pass to 4-pass, 1-pass shared to 4-pass shared, 5-NN, 20-NN (any "
                                 "number) and DT");
  GraphParams params;
  params.passes = number;
  params.grids = shared ? PassGrids::kShared : PassGrids::kOwn;
  params.check();
  return orderedZorderGraph(points, gridOf(points), params);
}

GraphSolution solveOnGraph(const std::string& graph, const Points& points, const Observations& observations,
                           const Fused& data, const SystemParams& params, Unanchored unanchored) {
  GraphSolution result;
  ProcessorWatch watch;
  OrderedGraph ordered = buildGraph(graph, points);
  const double graph_seconds = watch.lap();
  result.num_edges = ordered.edges.size();
  double statistic_seconds = 0;  // what is only a statistic does not count
  const auto anchoring = [&](const std::vector<Edge>& edges, Values& values) {
    ProcessorWatch statistic;
    Eigen::VectorXf anchors = randomAnchors(points, data, params);
    const std::vector<Index> free = freePoints(anchors, edges, &result.unanchored_share);
    statistic_seconds = statistic.lap();
    if (unanchored == Unanchored::kAnchored) return dataWeights(points, data, edges, params);
    for (const Index p : free) {
      anchors[p] = 1;
      values.col(p).setZero();
    }
    return anchors;
  };
  Solution solution = solveOnGraph(std::move(ordered), observations, data, params, anchoring);
  result.values = std::move(solution.values);
  result.seconds = solution.seconds;
  result.seconds.graph = graph_seconds;
  result.seconds.assembly -= statistic_seconds;
  return result;
}

}  // namespace cloud_colorizer
