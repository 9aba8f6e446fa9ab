// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the sensors of a drive measure.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "simulation/drive.hpp"
#include "simulation/scene.hpp"

namespace cloud_colorizer::simulation {

/// Bearings of all pixels of a camera; made once, used for every image of it.
class PixelRays {
 public:
  explicit PixelRays(const Camera& camera, int num_threads = 0);
  int width() const { return width_; }
  int height() const { return height_; }

  /// Unit bearing at a pixel, and up to half a pixel beside it; zero where the model has no inverse.
  Eigen::Vector3f bearing(int u, int v) const { return bearings_[index(u, v)]; }
  Eigen::Vector3f bearingBeside(int u, int v, float du, float dv) const;
  float pixelAngle() const { return pixel_angle_; }  ///< rad, of a pixel at the middle of the image

 private:
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  int width_, height_;
  float pixel_angle_;
  std::vector<Eigen::Vector3f> bearings_;
};

/// map_from_camera when a share of the image was read: 0 at its first row, 1 after its last.
using PoseWhileRead = std::function<Eigen::Isometry3d(double share)>;

/// True colours as a camera sees them at `time` [s], CV_32FC3 RGB, edges smoothed. One thread.
cv::Mat3f renderImage(const Scene& scene, const PixelRays& rays, const PoseWhileRead& map_from_camera, double time);

/// What the camera makes of it: gain, vignetting, noise (key chooses it), clipping; CV_8UC3 RGB.
cv::Mat3b exposeImage(const cv::Mat3f& image, const Color& gain, double vignetting, double noise, std::uint64_t key);

/// Image of a camera of a drive as it leaves the camera.
cv::Mat3b takeImage(const Scene& scene, const Drive& drive, const PixelRays& rays, int camera, int frame);

struct Return {
  Eigen::Vector3f point{0, 0, 0};  ///< m, LiDAR's frame at the scan's stamp (at its time if skewed), with range noise
  float intensity = 0;             ///< 0 to 255
  std::uint16_t ring = 0;          ///< 0: the lowest beam
  float time = 0;                  ///< s after the scan's stamp
  Hit truth;                       ///< where the ray really ended
};

/// One revolution. One thread.
std::vector<Return> takeScan(const Scene& scene, const Drive& drive, int frame);

}  // namespace cloud_colorizer::simulation
