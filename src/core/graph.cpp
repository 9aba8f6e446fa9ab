// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/graph.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "cloud_colorizer/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kMinEdgeWeight = 1e-6;

using Link = std::pair<std::uint32_t, std::uint32_t>;  // first < second

/// A block of the grid's binary tree: the points at which each pass enters and leaves it.
struct Block {
  std::array<std::uint32_t, kMaxPasses> first, last;
  int split = 0;  // highest bit in which the keys of this block and of the next one on the stack differ

  explicit Block(std::uint32_t point) {
    first.fill(point);
    last.fill(point);
  }
};

/// Highest bit in which two keys differ, -1 if none.
int splitBit(std::uint64_t a, std::uint64_t b) {
  return a == b ? -1 : 63 - __builtin_clzll(a ^ b);
}

class BlockLinker {
 public:
  explicit BlockLinker(int passes) : passes_(passes) {
    for (int pass = 0; pass < passes; ++pass) masks_[pass] = zorderMask(pass);
  }

  /// Joins `low` and `high`, that differ in bit low.split, and links them once in every pass.
  void join(Block& low, const Block& high, std::vector<Link>& links) const {
    const std::size_t begin = links.size();
    for (int pass = 0; pass < passes_; ++pass) {
      // A pass that mirrors this bit's axis visits the high half before the low one; equal keys keep their order.
      const bool mirrored = low.split >= 0 && (masks_[pass] >> low.split & 1) != 0;
      const std::uint32_t a = mirrored ? high.last[pass] : low.last[pass];
      const std::uint32_t b = mirrored ? low.first[pass] : high.first[pass];
      const Link link(std::min(a, b), std::max(a, b));
      if (std::find(links.begin() + begin, links.end(), link) == links.end()) links.push_back(link);
      (mirrored ? low.first : low.last)[pass] = (mirrored ? high.first : high.last)[pass];
    }
    low.split = high.split;
  }

 private:
  int passes_;
  std::array<std::uint64_t, kMaxPasses> masks_{};
};

/// Unique links of all passes, those inside of a block before those out of it.
std::vector<Link> passLinks(const std::vector<std::uint64_t>& keys, int passes) {
  const std::vector<std::uint32_t> order = zorderSort(keys, 0);
  const BlockLinker linker(passes);
  std::vector<Link> links;
  links.reserve(keys.size() * (passes == 1 ? 1 : 2));
  std::vector<Block> stack;  // splits descend from the bottom, so it holds 64 blocks at most
  for (std::size_t i = 0; i < order.size(); ++i) {
    stack.emplace_back(order[i]);
    stack.back().split = i + 1 < order.size() ? splitBit(keys[order[i]], keys[order[i + 1]]) : 64;
    while (stack.size() > 1 && stack[stack.size() - 2].split <= stack.back().split) {
      linker.join(stack[stack.size() - 2], stack.back(), links);
      stack.pop_back();
    }
  }
  return links;
}

/// Points by their last link: from the back, every point that is new.
std::vector<int> orderByLastLink(std::size_t num_points, const std::vector<Link>& links) {
  std::vector<int> order(num_points);
  std::vector<std::uint8_t> placed(num_points, 0);
  std::size_t end = num_points;
  const auto place = [&](std::uint32_t point) {
    if (placed[point]) return;
    placed[point] = 1;
    order[--end] = static_cast<int>(point);
  };
  for (auto link = links.rbegin(); link != links.rend(); ++link) {
    place(link->first);
    place(link->second);
  }
  for (std::uint32_t point = 0; end > 0; ++point) place(point);  // one point alone has no link
  return order;
}

/// Running sums in place: counts in offsets[i + 1] become starts in offsets[i].
void countsToOffsets(std::vector<std::uint32_t>& offsets) {
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
}

std::vector<Edge> sortedEdges(std::size_t num_points, const std::vector<Link>& links) {
  std::vector<std::uint32_t> offsets(num_points + 1, 0), seconds(links.size());
  for (const Link& link : links) ++offsets[link.first + 1];
  countsToOffsets(offsets);
  std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
  for (const Link& link : links) seconds[next[link.first]++] = link.second;
  std::vector<Edge> edges(links.size());
  for (std::uint32_t p = 0; p < num_points; ++p) {
    std::sort(seconds.begin() + offsets[p], seconds.begin() + offsets[p + 1]);
    for (std::uint32_t e = offsets[p]; e < offsets[p + 1]; ++e) edges[e] = {p, seconds[e], 1.0F};
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
  const std::vector<Link> links = passLinks(keys, params.passes);
  OrderedGraph graph{sortedEdges(keys.size(), links), orderByLastLink(keys.size(), links)};
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
