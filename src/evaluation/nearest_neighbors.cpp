// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"

#ifdef CLOUD_COLORIZER_NANOFLANN
#include <nanoflann.hpp>
#endif

namespace cloud_colorizer {

#ifdef CLOUD_COLORIZER_NANOFLANN
namespace {

struct PointsAdaptor {
  PointsRef points;
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.cols()); }
  float kdtree_get_pt(std::size_t p, std::size_t axis) const {
    return points(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(p));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsAdaptor, float, std::uint32_t>,
                                        PointsAdaptor, 3, std::uint32_t>;
constexpr std::size_t kBlock = 4096;

/// Newer versions build the index in the constructor.
void buildOldTree([[maybe_unused]] Tree& tree) {
#if NANOFLANN_VERSION < 0x142
  tree.buildIndex();
#endif
}

}  // namespace

bool hasNearestNeighbors() {
  return true;
}

std::vector<Neighbor> nearestNeighbors(PointsRef points, PointsRef queries) {
  std::vector<Neighbor> nearest(static_cast<std::size_t>(queries.cols()));
  if (nearest.empty()) return nearest;
  require<std::invalid_argument>(points.cols() > 0, "there are no points among which to find the nearest");
  const PointsAdaptor adaptor{points};
  Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  buildOldTree(tree);
  parallelFor(0, (nearest.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t q = block * kBlock; q < std::min(nearest.size(), (block + 1) * kBlock); ++q) {
      float squared = 0;
      tree.knnSearch(queries.col(static_cast<Eigen::Index>(q)).data(), 1, &nearest[q].index, &squared);
      nearest[q].distance = std::sqrt(squared);
    }
  });
  return nearest;
}

std::vector<Edge> knnGraph(PointsRef points, int k) {
  requireInRange("k", k, 1, 1000);
  const auto num_points = static_cast<std::size_t>(points.cols());
  const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(k) + 1, num_points);  // with the point itself
  std::vector<std::uint64_t> links(num_points * wanted, 0);  // (p, q) as one number; 0 is no link
  if (num_points < 2) return {};
  const PointsAdaptor adaptor{points};
  Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  buildOldTree(tree);
  parallelFor(0, (num_points + kBlock - 1) / kBlock, [&](std::size_t block) {
    std::vector<std::uint32_t> found(wanted);
    std::vector<float> squared(wanted);
    for (std::size_t p = block * kBlock; p < std::min(num_points, (block + 1) * kBlock); ++p) {
      tree.knnSearch(points.col(static_cast<Eigen::Index>(p)).data(), wanted, found.data(), squared.data());
      for (std::size_t i = 0, kept = 0; i < wanted && kept + 1 < wanted; ++i) {
        if (found[i] == p) continue;
        links[p * wanted + kept++] = static_cast<std::uint64_t>(std::min<std::uint64_t>(p, found[i])) << 32 |
                                     std::max<std::uint64_t>(p, found[i]);
      }
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

#else

bool hasNearestNeighbors() {
  return false;
}

namespace {
void refuse() {
  require(false, "built without nanoflann (Debian: libnanoflann-dev), so there is no nearest-neighbour search");
}
}  // namespace

std::vector<Neighbor> nearestNeighbors(PointsRef, PointsRef) {
  refuse();
  return {};
}

std::vector<Edge> knnGraph(PointsRef, int) {
  refuse();
  return {};
}

#endif

}  // namespace cloud_colorizer
