// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/neighbors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace cloud_colorizer {
namespace {

Points randomPoints(int count) {
  std::srand(7);
  return Points::Random(3, count);
}

std::set<std::pair<std::uint32_t, std::uint32_t>> asSet(const std::vector<Edge>& edges) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Edge& edge : edges) {
    EXPECT_LT(edge.p, edge.q);
    pairs.emplace(edge.p, edge.q);
  }
  EXPECT_EQ(pairs.size(), edges.size());
  EXPECT_TRUE(std::is_sorted(edges.begin(), edges.end(),
                             [](const Edge& a, const Edge& b) { return std::pair(a.p, a.q) < std::pair(b.p, b.q); }));
  return pairs;
}

TEST(KnnGraph, EqualsBruteForce) {
  const Points points = randomPoints(200);
  std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t p = 0; p < 200; ++p) {
    std::vector<std::pair<float, std::uint32_t>> order;
    for (std::uint32_t q = 0; q < 200; ++q) {
      if (q != p) order.emplace_back((points.col(p) - points.col(q)).squaredNorm(), q);
    }
    std::sort(order.begin(), order.end());
    for (int i = 0; i < 5; ++i) expected.emplace(std::min(p, order[i].second), std::max(p, order[i].second));
  }
  EXPECT_EQ(asSet(knnGraph(points, 5)), expected);
}

TEST(KnnGraph, FewOrEqualPointsGiveNoEdgeToThemselves) {
  EXPECT_TRUE(knnGraph(Points(3, 0), 5).empty());
  EXPECT_TRUE(knnGraph(Points::Zero(3, 1), 5).empty());
  EXPECT_EQ(knnGraph(randomPoints(3), 20).size(), 3U);
  asSet(knnGraph(Points::Zero(3, 40), 5));
}

TEST(Delaunay, CubeWithCentreLinksTheCentreWithEveryCorner) {
  if (!hasDelaunay()) GTEST_SKIP() << "built without CGAL";
  Points points(3, 9);
  for (int corner = 0; corner < 8; ++corner) {
    points.col(corner) = Eigen::Vector3f(static_cast<float>(corner & 1), static_cast<float>(corner >> 1 & 1),
                                         static_cast<float>(corner >> 2));
  }
  points.col(8).setConstant(0.5F);
  const auto edges = asSet(delaunayGraph(points));
  for (std::uint32_t corner = 0; corner < 8; ++corner) EXPECT_EQ(edges.count({corner, 8}), 1U);
  for (std::uint32_t axis : {1U, 2U, 4U}) EXPECT_EQ(edges.count({0, axis}), 1U);
  EXPECT_EQ(edges.count({0, 7}), 0U);
}

TEST(Delaunay, NothingGivesNothing) {
  if (!hasDelaunay()) GTEST_SKIP() << "built without CGAL";
  EXPECT_TRUE(delaunayGraph(Points(3, 0)).empty());
}

}  // namespace
}  // namespace cloud_colorizer
