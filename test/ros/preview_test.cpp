// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/preview.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>

namespace cloud_colorizer {
namespace {

/// Points on a plane in front of a camera at the origin.
Cloud wall(double z, int half_width) {
  Cloud cloud;
  cloud.positions.resize(3, (2 * half_width + 1) * (2 * half_width + 1));
  Eigen::Index i = 0;
  for (int x = -half_width; x <= half_width; ++x) {
    for (int y = -half_width; y <= half_width; ++y) cloud.positions.col(i++) = Eigen::Vector3d(0.1 * x, 0.1 * y, z);
  }
  return cloud;
}

Camera camera() {
  Intrinsics intrinsics;
  intrinsics.width = 160;
  intrinsics.height = 120;
  intrinsics.fx = intrinsics.fy = 100;
  intrinsics.cx = 80;
  intrinsics.cy = 60;
  return Camera(intrinsics);
}

struct Record {
  std::uint32_t rgb;
  std::uint16_t count;
  float stddev;
};
Record recordOf(const Cloud& cloud, Eigen::Index point) {
  const std::uint8_t* bytes = cloud.records.data() + static_cast<std::size_t>(point) * recordSize(cloud.fields);
  Record record;
  std::memcpy(&record.rgb, bytes, 4);
  std::memcpy(&record.count, bytes + 4, 2);
  std::memcpy(&record.stddev, bytes + 6, 4);
  return record;
}

TEST(RunningPreview, EmptyGivesAnEmptyCloud) {
  RunningPreview preview(0.1, 10);
  preview.addCloud({}, Eigen::Isometry3d::Identity(), 0, 10);
  preview.addView(camera(), Eigen::Isometry3d::Identity(), cv::Mat3b(30, 40), 10);
  EXPECT_EQ(preview.cloud(Eigen::Vector3d::Zero()).positions.cols(), 0);
}

TEST(RunningPreview, MeanOfTheViewsThatSeeThePoint) {
  RunningPreview preview(0.05, 1000);
  preview.addCloud(wall(5, 3), Eigen::Isometry3d::Identity(), 0, 10);
  preview.addView(camera(), Eigen::Isometry3d::Identity(), cv::Mat3b(30, 40, cv::Vec3b(0, 0, 100)), 10);
  preview.addView(camera(), Eigen::Isometry3d::Identity(), cv::Mat3b(30, 40, cv::Vec3b(0, 0, 200)), 10);
  preview.addView(camera(), Eigen::Isometry3d::Identity(), cv::Mat3b(30, 40, cv::Vec3b(0, 0, 255)), 2);  // too far
  const Cloud cloud = preview.cloud(Eigen::Vector3d(0, 0, 1));
  ASSERT_EQ(cloud.positions.cols(), 49);
  EXPECT_NEAR(cloud.positions(2, 0), 4, 1e-12);
  EXPECT_EQ(recordOf(cloud, 0).rgb, 150U << 16U);
  EXPECT_EQ(recordOf(cloud, 0).count, 2);
  EXPECT_NEAR(recordOf(cloud, 0).stddev, std::sqrt(2 * 50.0 * 50 / 6), 1e-3);
}

TEST(RunningPreview, WallHidesWhatIsBehind) {
  RunningPreview preview(0.05, 10000);
  preview.addCloud(wall(4, 15), Eigen::Isometry3d::Identity(), 0, 20);
  preview.addCloud(wall(9, 3), Eigen::Isometry3d::Identity(), 0, 20);
  preview.addView(camera(), Eigen::Isometry3d::Identity(), cv::Mat3b(30, 40, cv::Vec3b(9, 9, 9)), 20);
  const Cloud cloud = preview.cloud(Eigen::Vector3d::Zero());
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    EXPECT_EQ(recordOf(cloud, i).count, cloud.positions(2, i) < 5 ? 1 : 0);
  }
}

TEST(RunningPreview, OldestPointsGoWhenItIsFull) {
  RunningPreview preview(1, 5);
  for (int i = 0; i < 12; ++i) {
    Cloud cloud;
    cloud.positions = Eigen::Vector3d(i + 0.5, 0, 0);
    preview.addCloud(cloud, Eigen::Isometry3d::Identity(), 0, 100);
  }
  const Cloud cloud = preview.cloud(Eigen::Vector3d::Zero());
  std::multiset<double> xs;
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) xs.insert(cloud.positions(0, i));
  EXPECT_EQ(xs, (std::multiset<double>{7.5, 8.5, 9.5, 10.5, 11.5}));
}

TEST(RunningPreview, NanAndRangeAreGated) {
  RunningPreview preview(0.1, 10);
  Cloud cloud;
  cloud.positions.resize(3, 3);
  cloud.positions << std::nan(""), 0.1, 50, 0, 0, 0, 0, 0, 0;
  preview.addCloud(cloud, Eigen::Isometry3d::Identity(), 1, 10);
  EXPECT_EQ(preview.numPoints(), 0U);
}

TEST(VoxelThinner, OnePointAVoxelAndNeverMoreThanAsked) {
  VoxelThinner thinner(0.2, 60);
  const Cloud dense = wall(5, 10);
  thinner.add(dense);
  thinner.add(dense);
  const Cloud thin = thinner.cloud();
  EXPECT_LE(thin.positions.cols(), 60);
  EXPECT_GT(thin.positions.cols(), 10);
  std::set<std::uint64_t> keys;
  for (Eigen::Index i = 0; i < thin.positions.cols(); ++i) {
    EXPECT_TRUE(keys.insert(voxelKey(thin.positions.col(i), thinner.voxelSize())).second);
  }
}

TEST(SelectPoints, TakesPositionsAndRecords) {
  Cloud cloud;
  cloud.fields = {{"ring", FieldType::kUint8, 1}};
  cloud.positions = Eigen::Matrix3d::Identity();
  cloud.records = {7, 8, 9};
  const Cloud selected = selectPoints(cloud, {2, 0});
  EXPECT_EQ(selected.records, (std::vector<std::uint8_t>{9, 7}));
  EXPECT_EQ(selected.positions(2, 0), 1);
}

}  // namespace
}  // namespace cloud_colorizer
