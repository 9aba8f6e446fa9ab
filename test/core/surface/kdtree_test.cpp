// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface/kdtree.hpp"

#include <gtest/gtest.h>
#include <pcl/kdtree/kdtree_flann.h>

#include "core/pcl_points.hpp"

namespace cloud_colorizer {
namespace {

TEST(KdTree, FindsTheNeighboursThatFlannFinds) {
  constexpr int kCount = 16;
  Points points = 10 * Points::Random(3, 3000);
  points.row(2).head(1000) *= 1e-3F;                  // a sheet,
  points.rightCols(100) = points.middleCols(7, 100);  // and points that are there twice
  const KdTree tree(points);
  pcl::KdTreeFLANN<pcl::PointXYZ> oracle;
  const auto cloud = test::pclPoints(points);
  oracle.setInputCloud(cloud);
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    std::uint32_t indices[kCount];
    float squared[kCount];
    tree.nearest(points.col(static_cast<Eigen::Index>(i)), kCount, indices, squared);
    std::vector<int> expected(kCount);
    std::vector<float> expected_squared(kCount);
    ASSERT_EQ(oracle.nearestKSearch(static_cast<int>(i), kCount, expected, expected_squared), kCount);
    for (std::size_t k = 0; k < kCount; ++k) {
      EXPECT_NEAR(squared[k], expected_squared[k], 1e-5F * expected_squared[k]);
      const bool is_tie = (k > 0 && expected_squared[k] == expected_squared[k - 1]) ||
                          (k + 1 < kCount && expected_squared[k] == expected_squared[k + 1]) || k + 1 == kCount;
      EXPECT_TRUE(is_tie || static_cast<int>(indices[k]) == expected[k]) << i << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace cloud_colorizer
