// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/view_cones.hpp"

#include <gtest/gtest.h>

#include <random>

namespace cloud_colorizer {
namespace {

const std::vector<Camera>& cameras() {
  static const std::vector<Camera> kAll = {
      Camera({640, 480, 500, 500, 319.5, 239.5, DistortionModel::kPlumbBob, {-0.2, 0.05}}),
      Camera({640, 480, 300, 300, 100, 400, DistortionModel::kPlumbBob, {}}),
      Camera({800, 800, 260, 260, 399.5, 399.5, DistortionModel::kEquidistant, {0.01}})};
  return kAll;
}

Eigen::Isometry3d randomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Eigen::Isometry3d pose(Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized());
  pose.translation() = 10 * Eigen::Vector3d(unit(random), unit(random), unit(random));
  return pose;
}

Eigen::AlignedBox3f randomBox(std::mt19937& random) {
  std::uniform_real_distribution<float> place(-30, 30), size(0.1F, 15);
  const Eigen::Vector3f low(place(random), place(random), place(random));
  return {low, Eigen::Vector3f(low + Eigen::Vector3f(size(random), size(random), size(random)))};
}

TEST(ViewCone, NoPointThatTheImageShowsIsInABoxLeftOut) {
  std::mt19937 random(3);
  constexpr double kMaxDistance = 25;
  int num_left_out = 0;
  for (int round = 0; round < 3000; ++round) {
    const Camera& camera = cameras()[static_cast<std::size_t>(round) % cameras().size()];
    const Eigen::Isometry3d pose = randomPose(random);
    const Eigen::AlignedBox3f box = randomBox(random);
    if (ViewCone(camera, pose, kMaxDistance).mayShow(box)) continue;
    ++num_left_out;
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3f point = pose.inverse().cast<float>() * box.sample();
      EXPECT_FALSE(point.norm() < kMaxDistance && camera.project(point));
    }
  }
  EXPECT_GT(num_left_out, 1000);
}

TEST(ViewCone, LeavesOutWhatIsBehindAndWhatIsFar) {
  const ViewCone cone(cameras()[0], Eigen::Isometry3d::Identity(), 20);
  const auto boxAt = [](float z) {
    return Eigen::AlignedBox3f(Eigen::Vector3f(-1, -1, z), Eigen::Vector3f(1, 1, z + 1));
  };
  EXPECT_TRUE(cone.mayShow(boxAt(10)));
  EXPECT_TRUE(cone.mayShow(boxAt(-0.5F)));  // the camera is in it
  EXPECT_FALSE(cone.mayShow(boxAt(-10)));
  EXPECT_FALSE(cone.mayShow(boxAt(25)));
}

}  // namespace
}  // namespace cloud_colorizer
