// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Pictures of a cloud: what a person looks at to judge the colours.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

struct PictureParams {
  int width = 1280, height = 720;                ///< px, 16 to 16384
  double field_of_view = 70;                     ///< deg, horizontal, 1 to 170
  double point_size = 0.06;                      ///< m, diameter of the disc that stands for a point
  Eigen::Vector3f background = {203, 216, 228};  ///< RGB, 0 to 255

  void check() const;  ///< throws std::invalid_argument
};

/// Pose of a camera at `eye` that looks at `target` with `up` upwards in the picture (the axis most across to it, +x
/// before +y before +z, when it looks straight down or up). Throws std::invalid_argument where the two are the same
/// point.
Eigen::Isometry3d lookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                         const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// A source of points and their colours (3 x n each, RGB 0 to 255); calls back for each block, the same every time.
using ColoredPoints = std::function<void(const std::function<void(PointsRef, ValuesRef)>&)>;

/// Draws the points, in the frame of the pose, as discs, nearer ones before farther ones, blended where they lie on
/// one surface. Points that are not finite, or nearer than 0.1 m, are left out. Goes through `points` twice; memory is
/// that of the picture. Returns CV_8UC3 in OpenCV's order (BGR).
cv::Mat drawPicture(const ColoredPoints& points, const Eigen::Isometry3d& map_from_camera, const PictureParams& params);

/// Colours for numbers (3 x n, RGB 0 to 255): dark blue for `low` to yellow for `high` and beyond; grey for NaN and
/// what is below `low`.
Values colorScale(const Eigen::Ref<const Eigen::VectorXf>& numbers, float low, float high);

/// Pictures (CV_8UC3) of one height side by side, each with its caption below; empty for none.
cv::Mat besideEachOther(const std::vector<cv::Mat>& pictures, const std::vector<std::string>& captions);

}  // namespace cloud_colorizer
