// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace cloud_colorizer {
namespace {

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

const ZOrderGrid kGrid{Eigen::Vector3f::Constant(-2), 0.05F};

Points sphere(int num_points) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  Points points(3, num_points);
  for (int i = 0; i < num_points; ++i) {
    points.col(i) = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
  }
  return points;
}

/// The definition: sort for every pass, link neighbours, let a set make them unique.
Pairs linksBySorting(const Points& points, int passes, PassGrids grids) {
  const auto keys = zorderKeys(points, kGrid);
  Pairs pairs;
  for (int pass = 0; pass < passes; ++pass) {
    const auto order = zorderSort(grids == PassGrids::kOwn ? shiftedKeys(keys, pass) : keys, zorderMask(pass));
    for (std::size_t i = 1; i < order.size(); ++i) pairs.insert(std::minmax(order[i - 1], order[i]));
  }
  return pairs;
}

double neighboursOf(const std::vector<Edge>& edges, int num_points) {
  return 2 * static_cast<double>(edges.size()) / num_points;
}

TEST(Graph, LinksAreTheNeighboursInTheSortedPasses) {
  const Points points = sphere(3000);  // several points in many cells of 5 cm
  for (const PassGrids grids : {PassGrids::kOwn, PassGrids::kShared}) {
    for (int passes = 1; passes <= kMaxPasses; ++passes) {
      const auto edges = zorderGraph(points, kGrid, {passes, grids});
      const Pairs expected = linksBySorting(points, passes, grids);
      ASSERT_EQ(edges.size(), expected.size());
      std::size_t e = 0;
      for (const auto& [p, q] : expected) {  // a set ascends, as the edges must
        EXPECT_EQ(edges[e].p, p);
        EXPECT_EQ(edges[e].q, q);
        EXPECT_EQ(edges[e++].weight, 1);
      }
    }
  }
}

TEST(Graph, EliminationOrderHasEveryPointOnceAndLittleFill) {
  const int num_points = 3000;
  const GraphParams shared{4, PassGrids::kShared};
  const auto graph = orderedZorderGraph(sphere(num_points), {Eigen::Vector3f::Constant(-2), 0.001F}, shared);
  std::vector<int> rank(num_points, -1);
  for (int i = 0; i < num_points; ++i) rank.at(graph.elimination_order.at(i)) = i;
  EXPECT_EQ(std::count(rank.begin(), rank.end(), -1), 0);
  std::vector<std::set<int>> later(num_points);  // elimination by the book
  for (const Edge& edge : graph.edges)
    later[std::min(rank[edge.p], rank[edge.q])].insert(std::max(rank[edge.p], rank[edge.q]));
  std::size_t entries = 0;
  for (int i = 0; i < num_points; ++i) {
    entries += later[i].size();
    if (!later[i].empty()) later[*later[i].begin()].insert(std::next(later[i].begin()), later[i].end());
  }
  EXPECT_LT(entries, 8U * num_points);
  EXPECT_EQ(orderedZorderGraph(Points::Zero(3, 1), kGrid, shared).elimination_order, std::vector<int>{0});
  EXPECT_TRUE(orderedZorderGraph(sphere(10), kGrid, {}).elimination_order.empty());  // none is known for own grids
}

TEST(Graph, NeighboursOfASurfaceInFourPasses) {
  const Points points = sphere(20000);
  const ZOrderGrid grid{Eigen::Vector3f::Constant(-2), 0.001F};
  EXPECT_NEAR(neighboursOf(zorderGraph(points, grid, {4, PassGrids::kShared}), 20000), 4.1, 0.2);
  EXPECT_NEAR(neighboursOf(zorderGraph(points, grid, {4, PassGrids::kOwn}), 20000), 5.8, 0.2);
}

/// The halves of a cube touch in a plane of blocks of every size. Passes of one grid cross it once each, those of
/// others wherever it lies within one of their blocks.
TEST(Graph, OwnGridsCrossTheBordersOfBlocks) {
  const Points points = sphere(20000);
  const ZOrderGrid grid{Eigen::Vector3f::Constant(-1), std::ldexp(1.F, -18)};  // x = 0 halves the block of 2^19 cells
  const auto crossing = [&](PassGrids grids) {
    const auto edges = zorderGraph(points, grid, {4, grids});
    return std::count_if(edges.begin(), edges.end(),
                         [&](const Edge& e) { return (points(0, e.p) < 0) != (points(0, e.q) < 0); });
  };
  EXPECT_LT(crossing(PassGrids::kShared), 50);
  EXPECT_GT(crossing(PassGrids::kOwn), 150) << crossing(PassGrids::kOwn);
}

TEST(Graph, ManyDuplicatesMakeOneChain) {
  const auto edges = zorderGraph(Points::Zero(3, 1000), kGrid, {});
  ASSERT_EQ(edges.size(), 999U);
  for (std::uint32_t i = 0; i < 999; ++i) EXPECT_EQ(edges[i].q, edges[i].p + 1);
}

TEST(Graph, ComponentsAreNumberedByTheirSmallestNode) {
  const std::vector<Edge> edges = {{0, 4}, {1, 3}, {2, 5, 0.0F}, {3, 6}, {4, 7}};  // weight 0 is no edge
  EXPECT_EQ(connectedComponents(8, edges), (std::vector<std::uint32_t>{0, 1, 2, 1, 0, 3, 1, 0}));
}

TEST(Graph, ComponentsOfAnUnknownNodeAreRefused) {
  EXPECT_THROW(connectedComponents(2, {{0, 2}}), std::invalid_argument);
}

TEST(Graph, BadParameterIsRefused) {
  EXPECT_THROW(zorderGraph(Points::Zero(3, 2), kGrid, {0}), std::invalid_argument);
  EXPECT_THROW(zorderGraph(Points::Zero(3, 2), kGrid, {5}), std::invalid_argument);
}

TEST(Graph, NoneAndOnePointHaveNoEdges) {
  EXPECT_TRUE(zorderGraph(Points(3, 0), kGrid, {}).empty());
  EXPECT_TRUE(zorderGraph(Points::Zero(3, 1), kGrid, {4}).empty());
  EXPECT_TRUE(connectedComponents(0, {}).empty());
}

}  // namespace
}  // namespace cloud_colorizer
