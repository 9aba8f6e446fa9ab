// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Small motions of cameras, and the corrections that they make.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cloud_colorizer/camera/view.hpp"

namespace cloud_colorizer::alignment {

/// p -> R p + t.
Eigen::Isometry3d motion(const Twist& twist);
/// The inverse of motion().
Twist twistOf(const Eigen::Isometry3d& motion);

/// Corrections: the camera's frame sees motion(views[v]) * (what it saw before). A view's correction is expected at
/// cameras[c] + time_offsets[c] * velocity of v.
struct PoseState {
  std::vector<Twist> views, cameras;
  std::vector<double> time_offsets;  ///< s
};
Eigen::Isometry3d correctedPose(const View& view, const Twist& correction);

}  // namespace cloud_colorizer::alignment
