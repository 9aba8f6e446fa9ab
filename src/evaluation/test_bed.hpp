// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The test bed of the paper's section 4.1: points on a textured Lambertian object and images of it from all around,
/// with known truth and known noise.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "evaluation/mesh.hpp"

namespace cloud_colorizer {

struct TestBedParams {
  std::size_t num_points = 300000;
  double scan_line_ratio = 0;  ///< 0: points sampled uniformly; else in scan lines, see sampleScanLines
  int num_views = 48;
  int width = 1280, height = 960;  ///< px
  double focal_length = 1500;      ///< px
  double fill = 0.94;              ///< share of the image's height that the object's bounding sphere takes
  double texture_frequency = 1;    ///< scales the texture; twice the number is half the size of the pattern
  std::uint64_t seed = 1;
  int num_threads = 0;  ///< 0: one a core

  void check() const;
};

/// Sizes of the noise, each a standard deviation; zero switches a kind off. The paper does not tell its sizes.
struct NoiseParams {
  double rotation = 0.15;  ///< deg about each axis of the camera
  double centre = 0.002;   ///< share of the diameter along each axis
  double gain = 0.1;       ///< of each view's brightness, about 1
  double pixel = 5;        ///< of 255, of each pixel and channel

  NoiseParams onlyExtrinsics() const { return {rotation, centre, 0, 0}; }
  NoiseParams onlyIntensities() const { return {0, 0, gain, pixel}; }
  void check() const;
};

/// An object with its images. The object has diameter 2 and is centred at zero.
struct TestBed {
  std::string name;
  double diameter = 2;
  Points points;                              ///< 3 x n
  Values truth;                               ///< 3 x n, colour with the shading baked in, RGB of 255
  Intrinsics intrinsics;                      ///< one pinhole camera for all views
  std::vector<Eigen::Isometry3d> true_poses;  ///< map_from_camera
  std::vector<Eigen::Isometry3d> poses;       ///< map_from_camera with noise: what a method is given
  std::vector<cv::Mat> images;                ///< CV_8UC3 RGB, with noise
  Eigen::ArrayXd gains;                       ///< of each view: image = gain * true image
};

/// Renders the object without noise (gains 1, poses = true_poses). About 0.2 s a view and core.
TestBed renderTestBed(const Mesh& mesh, const TestBedParams& params);

/// A copy with noise; `clean` comes from renderTestBed. The same for the same seed, whatever the number of threads.
TestBed addNoise(const TestBed& clean, const NoiseParams& noise, std::uint64_t seed, int num_threads = 0);

/// Both in one, with the seed and threads of `params`.
TestBed noisyBed(const Mesh& mesh, const TestBedParams& params, const NoiseParams& noise);

/// Albedo (0 to 1, RGB) at a point of an object of diameter 2: smooth areas and sharp borders at several frequencies.
Eigen::Vector3f textureAlbedo(const Eigen::Vector3f& point, float frequency = 1);

/// Colour of 255 under two distant lights and ambient light: albedo * shading, the same from every direction.
Eigen::Vector3f shadedColor(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float frequency);

/// Image of the mesh (CV_8UC3 RGB, 2 x 2 samples a pixel, black background).
cv::Mat renderMesh(const Mesh& mesh, const Intrinsics& intrinsics, const Eigen::Isometry3d& map_from_camera,
                   float texture_frequency);

/// Poses on a Fibonacci sphere of the given radius about zero, looking at zero.
std::vector<Eigen::Isometry3d> posesAround(int count, double radius);

/// Mean over views and points in front of them of the distance between the projections with `poses` and with the true
/// poses, px; the measure of a misregistration.
double meanReprojectionError(const TestBed& bed, const std::vector<Eigen::Isometry3d>& poses);

}  // namespace cloud_colorizer
