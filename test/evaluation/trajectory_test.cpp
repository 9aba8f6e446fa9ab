// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer {
namespace {

View viewAt(double stamp, std::uint32_t camera = 0) {
  View view;
  view.camera = camera;
  view.stamp = stamp;
  view.map_from_camera = Eigen::Translation3d(10 * stamp, 0, 0) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ());
  return view;
}

/// Given pose, then a shift along the camera's x axis.
Eigen::Isometry3d shifted(const View& view, double by) {
  return view.map_from_camera * Eigen::Translation3d(by, 0, 0);
}

TEST(Trajectory, CorrectionIsThatOfTheNeighboursInTime) {
  const std::vector<View> views = {viewAt(0), viewAt(0.1, 1), viewAt(0.4)};
  const std::vector<Eigen::Isometry3d> corrected = {shifted(views[0], 0.1), shifted(views[1], 9),
                                                    shifted(views[2], 0.3)};
  const View between = viewAt(0.1);
  EXPECT_TRUE(poseOnTrajectory(between, views, corrected).isApprox(shifted(between, 0.15), 1e-9));
  const View last = viewAt(0.6);
  EXPECT_TRUE(poseOnTrajectory(last, views, corrected).isApprox(shifted(last, 0.3), 1e-9));
  const View exact = viewAt(0.4);
  EXPECT_TRUE(poseOnTrajectory(exact, views, corrected).isApprox(shifted(exact, 0.3), 1e-9));
}

TEST(Trajectory, WithoutNeighboursAViewMovesWithTheMap) {
  const std::vector<View> views = {viewAt(0), viewAt(3, 1), viewAt(9)};
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.1, -0.2, 0.3) * Eigen::AngleAxisd(0.001, Eigen::Vector3d(1, 2, 2).normalized());
  std::vector<Eigen::Isometry3d> corrected;
  for (const View& view : views) corrected.push_back(motion * view.map_from_camera);
  const View lonely = viewAt(5);
  const Eigen::Isometry3d moved = poseOnTrajectory(lonely, views, corrected);
  EXPECT_TRUE(moved.isApprox(motion * lonely.map_from_camera, 1e-6)) << moved.matrix();
  corrected[0].translation().x() += 0.3, corrected[2].translation().x() -= 0.3;  // what they have not in common
  EXPECT_TRUE(poseOnTrajectory(lonely, views, corrected).isApprox(moved, 1e-9));
  EXPECT_TRUE(poseOnTrajectory(lonely, {}, {}).isApprox(lonely.map_from_camera));
}

}  // namespace
}  // namespace cloud_colorizer
