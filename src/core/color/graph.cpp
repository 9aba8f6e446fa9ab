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

/// The links as edges, each once.
std::vector<Edge> sortedEdges(std::size_t num_points, const std::vector<Link>& links) {
  std::vector<std::uint32_t> offsets(num_points + 1, 0), seconds(links.size());
  for (const Link& link : links) ++offsets[link.first + 1];
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
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

}  // namespace

void GraphParams::check() const {
  requireInRange("passes", passes, 1, kMaxPasses);
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
