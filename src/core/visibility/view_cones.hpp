// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Which boxes a view may show: asked before anything in them is looked at.
#pragma once

#include <Eigen/Geometry>

#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

/// What lies around the optical axis, as far as the farthest image corner, and nearer than a distance [m].
class ViewCone {
 public:
  ViewCone(const Camera& camera, const Eigen::Isometry3d& map_from_camera, double max_distance);

  /// False only where no point of the box can lie in the cone.
  bool mayShow(const Eigen::AlignedBox3f& box) const;

 private:
  Eigen::Isometry3d camera_from_map_;
  double angle_ = 0;  ///< rad, from the axis
  double max_distance_;
  double half_way_, half_turn_;  ///< m and rad, of the motion of a rolling shutter, see Camera::reach()
};

}  // namespace cloud_colorizer
