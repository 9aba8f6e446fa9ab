// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/visible.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

/// A wall of 11 x 11 points 10 cm apart, 5 m in front of a camera at the map's far origin; its left half has colours.
class Wall : public testing::Test {
 protected:
  Wall() {
    cloud_.fields = {{"rgb", FieldType::kFloat32, 1}, {"view_count", FieldType::kUint16, 1}};
    cloud_.fields.push_back({"seen", FieldType::kUint8, 1});
    cloud_.positions.resize(3, 121);
    const std::size_t size = recordSize(cloud_.fields);
    cloud_.records.assign(121 * size, 0);
    for (int i = 0; i < 121; ++i) {
      cloud_.positions.col(i) = kFar + Eigen::Vector3d(0.1 * (i % 11 - 5), 0.1 * (i / 11 - 5), 5);
      const std::uint16_t views = i % 11 < 5 ? 3 : 0;
      std::memcpy(cloud_.records.data() + static_cast<std::size_t>(i) * size + 4, &views, 2);
    }
    pose_.translation() = kFar;
  }

  const Eigen::Vector3d kFar{500000, 5000000, 100};
  Cloud cloud_;
  Camera camera_{{100, 100, 100, 100, 49.5, 49.5, DistortionModel::kPlumbBob, {}}};
  Eigen::Isometry3d pose_ = Eigen::Isometry3d::Identity();
};

TEST_F(Wall, ReturnsInTheImageCountByTheColourOfTheirPoint) {
  const VisibleReturns map(cloud_, "map", 0);
  EXPECT_NEAR(map.maxDistance(), 0.3, 1e-3);
  Eigen::Matrix3Xd returns(3, 5);
  returns << -0.41, 0.22, 0, 0, -9,  //
      0, 0.1, 0.1, 0, 0,             //
      5, 5, 6, -5, 5;                // coloured, not coloured, not in the map, behind the camera, beside the image
  const VisibleCounts counts = map.count(returns.colwise() + kFar, camera_, pose_);
  EXPECT_EQ(counts.seen, 3U);
  EXPECT_EQ(counts.in_map, 2U);
  EXPECT_EQ(counts.colored, 1U);
  EXPECT_EQ(counts.describe(), "1 views: 3 certainly seen, 66.67 % of them in the map; coloured 50.00 %");
}

TEST_F(Wall, FieldSeenTellsWhatWasSeen) {
  const std::size_t size = recordSize(cloud_.fields);
  for (const std::size_t p : {0U, 1U, 8U}) cloud_.records[p * size + 6] = 1;
  const VisibleCounts counts = countSeen(cloud_, "map");
  EXPECT_EQ(counts.describe(), "3 certainly seen; coloured 66.67 %");
}

TEST_F(Wall, WhatCannotBeComparedIsAnError) {
  Cloud bare = cloud_;
  bare.fields.pop_back();
  EXPECT_ERROR(countSeen(bare, "some.ply"), "some.ply: the cloud has no field 'seen'");
  EXPECT_ERROR(VisibleReturns(Cloud{}, "some.ply", 0), "some.ply");
}

}  // namespace
}  // namespace cloud_colorizer
