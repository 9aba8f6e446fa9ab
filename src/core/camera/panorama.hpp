// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images of all directions (equirectangular, of 360 degree cameras) as the six faces of a cube around the camera, each
/// an image of a pinhole camera. All that follows knows such cameras only.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

struct PanoramaFace {
  std::string name;       ///< front, right, back, left, up, down
  Intrinsics intrinsics;  ///< a little more than 90 degrees, at the resolution of the panorama's equator
  Eigen::Matrix3d panorama_from_face;
};

/// Of a panorama that is `width` [px] wide and half as high. Its frame: z to the middle of the image, x right, y down.
std::vector<PanoramaFace> panoramaFaces(int width);

/// Throws std::invalid_argument where the image is not twice as wide as high.
void checkPanorama(cv::Size size);

/// The part of an image that a face shows, by cubic interpolation. Any type that OpenCV resamples.
cv::Mat cutFace(const cv::Mat& panorama, const PanoramaFace& face);
/// The same of a mask: 0 where any pixel that a pixel of the face is made of is 0. Empty of an empty one.
cv::Mat cutMask(const cv::Mat& mask, const PanoramaFace& face);

}  // namespace cloud_colorizer
