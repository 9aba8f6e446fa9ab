// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/graph.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "cloud_colorizer/base/check.hpp"
#include "color/pass_links.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kMinEdgeWeight = 1e-6;

/// Running sums in place: counts in offsets[i + 1] become starts in offsets[i].
void countsToOffsets(std::vector<std::uint32_t>& offsets) {
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
}

/// The links as edges, each once.
std::vector<Edge> sortedEdges(std::size_t num_points, const std::vector<Link>& links) {
  std::vector<std::uint32_t> offsets(num_points + 1, 0), seconds(links.size());
  for (const Link& link : links) ++offsets[link.first + 1];
  countsToOffsets(offsets);
  std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
  for (const Link& link : links) seconds[next[link.first]++] = link.second;
  std::vector<Edge> edges;
  edges.reserve(links.size());
  for (std::uint32_t p = 0; p < num_points; ++p) {
    const auto begin = seconds.begin() + offsets[p], end = seconds.begin() + offsets[p + 1];
    std::sort(begin, end);
    for (auto q = begin; q != end; ++q) {
      if (q == begin || *q != *(q - 1)) edges.push_back({p, *q, 1.0F});
    }
  }
  return edges;
}

/// Median length of every point's edges, of two middle ones the shorter; 0 for a point without edges.
std::vector<float> medianLengths(std::size_t num_points, const std::vector<Edge>& edges,
                                 const std::vector<float>& edge_lengths) {
  std::vector<std::uint32_t> offsets(num_points + 1, 0);
  for (const Edge& edge : edges) ++offsets[edge.p + 1], ++offsets[edge.q + 1];
  countsToOffsets(offsets);
  std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
  std::vector<float> lengths(2 * edges.size()), medians(num_points, 0.0F);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    lengths[next[edges[e].p]++] = edge_lengths[e];
    lengths[next[edges[e].q]++] = edge_lengths[e];
  }
  for (std::size_t p = 0; p < num_points; ++p) {
    if (offsets[p] == offsets[p + 1]) continue;
    const auto middle = lengths.begin() + (offsets[p] + offsets[p + 1] - 1) / 2;
    std::nth_element(lengths.begin() + offsets[p], middle, lengths.begin() + offsets[p + 1]);
    medians[p] = *middle;
  }
  return medians;
}

void weighByLength(PointsRef points, double cell, double ratio, std::vector<Edge>& edges) {
  std::vector<float> lengths(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e) lengths[e] = (points.col(edges[e].p) - points.col(edges[e].q)).norm();
  const std::vector<float> medians = medianLengths(static_cast<std::size_t>(points.cols()), edges, lengths);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const double spacing = std::max(cell, 0.5 * (medians[edges[e].p] + medians[edges[e].q]));
    if (lengths[e] <= ratio * spacing) continue;
    const double relative = ratio * spacing / lengths[e];
    edges[e].weight = static_cast<float>(std::max(kMinEdgeWeight, relative * relative));
  }
}

}  // namespace

void GraphParams::check() const {
  requireInRange("passes", passes, 1, kMaxPasses);
  requireInRange("edge_length_ratio", edge_length_ratio, 0.0, 1e6);
}

OrderedGraph orderedZorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params) {
  params.check();
  require<std::out_of_range>(points.cols() <= std::numeric_limits<int>::max(), points.cols(),
                             " points exceed 32-bit indices; use smaller chunks");
  const std::vector<std::uint64_t> keys = zorderKeys(points, grid);
  const bool shared = params.grids == PassGrids::kShared;
  const std::vector<Link> links = (shared ? sharedGridLinks : ownGridLinks)(keys, params.passes);
  OrderedGraph graph{sortedEdges(keys.size(), links), {}};
  if (shared) graph.elimination_order = orderByLastLink(keys.size(), links);
  if (params.edge_length_ratio > 0) weighByLength(points, grid.cell, params.edge_length_ratio, graph.edges);
  return graph;
}

std::vector<Edge> zorderGraph(PointsRef points, const ZOrderGrid& grid, const GraphParams& params) {
  return orderedZorderGraph(points, grid, params).edges;
}

std::vector<std::uint32_t> connectedComponents(std::size_t num_points, const std::vector<Edge>& edges) {
  std::vector<std::uint32_t> parents(num_points);
  std::iota(parents.begin(), parents.end(), 0U);
  const auto root = [&](std::uint32_t node) {
    while (parents[node] != node) node = parents[node] = parents[parents[node]];
    return node;
  };
  for (const Edge& edge : edges) {
    require<std::invalid_argument>(edge.p < num_points && edge.q < num_points, "edge (", edge.p, ", ", edge.q,
                                   ") in a graph of ", num_points, " points");
    if (!(edge.weight > 0)) continue;
    const std::uint32_t a = root(edge.p), b = root(edge.q);
    parents[std::max(a, b)] = std::min(a, b);  // so that a root is the smallest node of its component
  }
  std::vector<std::uint32_t> labels(num_points);
  std::uint32_t num_labels = 0;
  for (std::uint32_t node = 0; node < num_points; ++node) {
    labels[node] = parents[node] == node ? num_labels++ : labels[root(node)];
  }
  return labels;
}

}  // namespace cloud_colorizer
