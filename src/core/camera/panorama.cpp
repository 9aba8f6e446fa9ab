// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/panorama.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kMargin = 4;  // px around a panorama for the interpolation, and of a face beyond 90 degrees

Eigen::Matrix3d columns(const Eigen::Vector3d& right, const Eigen::Vector3d& down, const Eigen::Vector3d& ahead) {
  return (Eigen::Matrix3d() << right, down, ahead).finished();
}

/// With what lies beyond its ends: the other end, and the rows at the poles once more.
cv::Mat padded(const cv::Mat& panorama) {
  cv::Mat wide, result;
  cv::copyMakeBorder(panorama, wide, 0, 0, kMargin, kMargin, cv::BORDER_WRAP);
  cv::copyMakeBorder(wide, result, kMargin, kMargin, 0, 0, cv::BORDER_REPLICATE);
  return result;
}

/// Where in the padded panorama each pixel of the face lies.
cv::Mat2f lookUpMap(cv::Size panorama, const PanoramaFace& face) {
  const Intrinsics& k = face.intrinsics;
  const Eigen::Matrix3d& turn = face.panorama_from_face;
  cv::Mat2f map(k.height, k.width);
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const Eigen::Vector3d ray = turn * Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1);
      const double around = std::atan2(ray.x(), ray.z()), below = std::atan2(ray.y(), std::hypot(ray.x(), ray.z()));
      const double x = (0.5 + around / (2 * CV_PI)) * panorama.width - 0.5;
      const double y = (0.5 + below / CV_PI) * panorama.height - 0.5;
      map(v, u) = {static_cast<float>(x + kMargin), static_cast<float>(y + kMargin)};
    }
  }
  return map;
}

}  // namespace

std::vector<PanoramaFace> panoramaFaces(int width) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  Intrinsics k;
  k.fx = k.fy = width / (2 * CV_PI);
  k.width = k.height = static_cast<int>(std::ceil(2 * k.fx)) + 2 * kMargin;
  k.cx = k.cy = 0.5 * (k.width - 1);
  return {{"front", k, columns(x, y, z)}, {"right", k, columns(-z, y, x)}, {"back", k, columns(-x, y, -z)},
          {"left", k, columns(z, y, -x)}, {"up", k, columns(x, z, -y)},    {"down", k, columns(x, -z, y)}};
}

void checkPanorama(cv::Size size) {
  require<std::invalid_argument>(size.height > 0 && size.width == 2 * size.height, "an image of ", size.width, " x ",
                                 size.height, " px is no equirectangular panorama, which is twice as wide as high");
}

cv::Mat cutFace(const cv::Mat& panorama, const PanoramaFace& face) {
  cv::Mat result;
  cv::remap(padded(panorama), result, lookUpMap(panorama.size(), face), cv::noArray(), cv::INTER_CUBIC,
            cv::BORDER_REPLICATE);
  return result;
}

cv::Mat cutMask(const cv::Mat& mask, const PanoramaFace& face) {
  if (mask.empty()) return {};
  cv::Mat usable;
  cv::erode(padded(mask != 0), usable, cv::Mat());  // by the reach of the interpolation
  cv::remap(usable, usable, lookUpMap(mask.size(), face), cv::noArray(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  return usable;
}

}  // namespace cloud_colorizer
