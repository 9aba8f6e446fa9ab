// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Pose of one image against a coloured map: so that a held-out image scores the map and not its own pose.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

/// Gauss-Newton on grey levels with one common gain, Huber weights, and the image blurred by 4, 2 and 1 px. `points`
/// (3 x n) are those that the view sees, `colors` the map's. Returns map_from_camera; the given one where nothing
/// improves or there are fewer than 100 points.
Eigen::Isometry3d refinePose(PointsRef points, ValuesRef colors, const Camera& camera, const cv::Mat3b& image,
                             const Eigen::Isometry3d& map_from_camera);

}  // namespace cloud_colorizer
