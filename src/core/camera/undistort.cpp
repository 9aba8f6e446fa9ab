// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/undistort.hpp"

namespace cloud_colorizer {

Intrinsics pinholeOf(const Intrinsics& intrinsics) {
  Intrinsics pinhole = intrinsics;
  pinhole.model = DistortionModel::kPlumbBob;
  pinhole.distortion.clear();
  return pinhole;
}

cv::Mat2f undistortionMap(const Intrinsics& camera) {
  const Camera from(camera);
  cv::Mat2f map(camera.height, camera.width);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
      const auto pixel = from.project(ray.cast<float>());
      map(v, u) = pixel ? cv::Vec2f(pixel->x(), pixel->y()) : cv::Vec2f(-1, -1);
    }
  }
  return map;
}

}  // namespace cloud_colorizer
