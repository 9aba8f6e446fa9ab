// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"
#include "surface/kdtree.hpp"

namespace cloud_colorizer {
namespace {

/// Calls visit(i) for every number below `count`, many in a row on one thread.
template <class Visit>
void forEachInBlocks(std::size_t count, const Visit& visit) {
  constexpr std::size_t kBlock = 4096;
  parallelFor(0, (count + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min(count, (block + 1) * kBlock); ++i) visit(i);
  });
}

}  // namespace

std::vector<Neighbor> nearestNeighbors(const Points& points, const Points& queries) {
  std::vector<Neighbor> nearest(static_cast<std::size_t>(queries.cols()));
  if (nearest.empty()) return nearest;
  require<std::invalid_argument>(points.cols() > 0, "there are no points among which to find the nearest");
  const KdTree tree(points);
  forEachInBlocks(nearest.size(), [&](std::size_t q) {
    float squared = 0;
    tree.nearest(queries.col(static_cast<Eigen::Index>(q)), 1, &nearest[q].index, &squared);
    nearest[q].distance = std::sqrt(squared);
  });
  return nearest;
}

std::vector<Edge> knnGraph(const Points& points, int k) {
  requireInRange("k", k, 1, 1000);
  const auto num_points = static_cast<std::size_t>(points.cols());
  const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(k) + 1, num_points);  // with the point itself
  std::vector<std::uint64_t> links(num_points * wanted, 0);  // (p, q) as one number; 0 is no link
  if (num_points < 2) return {};
  const KdTree tree(points);
  forEachInBlocks(num_points, [&](std::size_t p) {
    std::vector<std::uint32_t> found(wanted);
    std::vector<float> squared(wanted);
    tree.nearest(points.col(static_cast<Eigen::Index>(p)), wanted, found.data(), squared.data());
    for (std::size_t i = 0, kept = 0; i < wanted && kept + 1 < wanted; ++i) {
      if (found[i] == p) continue;
      links[p * wanted + kept++] =
          static_cast<std::uint64_t>(std::min<std::uint64_t>(p, found[i])) << 32 | std::max<std::uint64_t>(p, found[i]);
    }
  });
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  std::vector<Edge> edges;
  edges.reserve(links.size());
  for (const std::uint64_t link : links) {
    if (link != 0) edges.push_back({static_cast<std::uint32_t>(link >> 32), static_cast<std::uint32_t>(link), 1});
  }
  return edges;
}

}  // namespace cloud_colorizer
