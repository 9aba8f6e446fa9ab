// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/motion.hpp"

namespace cloud_colorizer::alignment {

Eigen::Isometry3d motion(const Twist& twist) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  const double angle = twist.head<3>().norm();
  if (angle > 0) result.linear() = Eigen::AngleAxisd(angle, twist.head<3>() / angle).toRotationMatrix();
  result.translation() = twist.tail<3>();
  return result;
}

Twist twistOf(const Eigen::Isometry3d& motion) {
  const Eigen::AngleAxisd rotation(motion.linear());
  Twist twist;
  twist << rotation.angle() * rotation.axis(), motion.translation();
  return twist;
}

Eigen::Isometry3d correctedPose(const View& view, const Twist& correction) {
  return view.map_from_camera * motion(correction).inverse();
}

}  // namespace cloud_colorizer::alignment
