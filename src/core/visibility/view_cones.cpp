// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/view_cones.hpp"

#include <algorithm>
#include <cmath>

namespace cloud_colorizer {

ViewCone::ViewCone(const Camera& camera, const Eigen::Isometry3d& map_from_camera, double max_distance)
    : camera_from_map_(map_from_camera.inverse()),
      max_distance_(max_distance),
      half_way_(camera.reach(0)),
      half_turn_(camera.reach(1) - camera.reach(0)) {
  const auto& k = camera.intrinsics();
  for (const double u : {-0.5, k.width - 0.5}) {
    for (const double v : {-0.5, k.height - 0.5}) {
      const auto bearing = camera.bearing({u, v});
      angle_ = std::max(angle_, bearing ? std::acos(std::clamp(bearing->z(), -1.0, 1.0)) : camera.maxAngle());
    }
  }
}

bool ViewCone::mayShow(const Eigen::AlignedBox3f& box) const {
  const Eigen::Vector3d center = camera_from_map_ * box.center().cast<double>();
  const double distance = center.norm();
  const double half_box = 0.5 * box.diagonal().cast<double>().norm();
  const double radius = half_box + half_turn_ * (distance + half_box) + half_way_;
  if (distance <= radius) return true;
  if (distance - radius > max_distance_) return false;
  const double angle = std::acos(std::clamp(center.z() / distance, -1.0, 1.0));
  return angle - std::asin(radius / distance) < angle_;
}

}  // namespace cloud_colorizer
