// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/test_bed.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace cloud_colorizer {
namespace {

TestBedParams smallParams() {
  TestBedParams params;
  params.num_points = 2000;
  params.num_views = 6;
  params.width = 320;
  params.height = 240;
  params.focal_length = 375;
  return params;
}

bool sameImages(const TestBed& a, const TestBed& b) {
  for (std::size_t v = 0; v < a.images.size(); ++v) {
    if (cv::norm(a.images[v], b.images[v], cv::NORM_INF) != 0) return false;
  }
  return a.images.size() == b.images.size();
}

Eigen::Vector2d pixelOf(const TestBed& bed, std::size_t view, Eigen::Index point) {
  const Eigen::Vector3d p = bed.true_poses[view].inverse() * bed.points.col(point).cast<double>();
  return {bed.intrinsics.fx * p.x() / p.z() + bed.intrinsics.cx, bed.intrinsics.fy * p.y() / p.z() + bed.intrinsics.cy};
}

TEST(TestBed, ImagesShowTheTrueColoursAtTheProjectedPoints) {
  Mesh sphere = bumpySphere(60);
  const TestBed bed = renderTestBed(sphere, smallParams());
  // Points that face the camera of view 0 on a nearly convex body are seen; smooth areas have no border nearby, so
  // the median difference is the quantisation.
  std::vector<double> errors;
  for (Eigen::Index p = 0; p < bed.points.cols(); ++p) {
    const Eigen::Vector3d towards = bed.true_poses[0].translation().normalized();
    if (bed.points.col(p).cast<double>().normalized().dot(towards) < 0.8) continue;
    const Eigen::Vector2d pixel = pixelOf(bed, 0, p);
    const auto& seen =
        bed.images[0].at<cv::Vec3b>(static_cast<int>(std::lround(pixel.y())), static_cast<int>(std::lround(pixel.x())));
    for (int c = 0; c < 3; ++c) errors.push_back(std::abs(seen[c] - static_cast<double>(bed.truth(c, p))));
  }
  ASSERT_GT(errors.size(), 300U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 2.0);
}

TEST(TestBed, EveryPointIsInsideEveryImage) {
  const TestBed bed = renderTestBed(knottedTorus(16), smallParams());
  for (std::size_t v = 0; v < bed.true_poses.size(); ++v) {
    for (Eigen::Index p = 0; p < bed.points.cols(); ++p) {
      const Eigen::Vector2d pixel = pixelOf(bed, v, p);
      ASSERT_TRUE(pixel.x() > 0 && pixel.x() < 319 && pixel.y() > 0 && pixel.y() < 239) << pixel.transpose();
    }
  }
}

TEST(TestBed, NoiseHasTheSizesAskedForAndEachKindCanBeOff) {
  TestBedParams params = smallParams();
  params.num_views = 200;
  params.width = 32;
  params.height = 24;
  params.focal_length = 37;
  const TestBed clean = renderTestBed(bumpySphere(10), params);
  const TestBed noisy = addNoise(clean, NoiseParams{}, 3);
  EXPECT_NEAR(noisy.gains.mean(), 1, 0.03);
  EXPECT_NEAR(std::sqrt((noisy.gains - noisy.gains.mean()).square().mean()), 0.1, 0.015);
  double angles = 0, centres = 0;
  for (std::size_t v = 0; v < 200; ++v) {
    angles += std::pow(
        Eigen::AngleAxisd(noisy.poses[v].linear().transpose() * clean.poses[v].linear()).angle() * 180 / M_PI, 2);
    centres += (noisy.poses[v].translation() - clean.poses[v].translation()).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(angles / 600), 0.15, 0.015);
  EXPECT_NEAR(std::sqrt(centres / 600), 0.004, 0.0004);
  const TestBed poses_only = addNoise(clean, NoiseParams{}.onlyExtrinsics(), 3);
  EXPECT_TRUE(sameImages(poses_only, clean));
  EXPECT_TRUE((poses_only.gains == 1).all());
  const TestBed images_only = addNoise(clean, NoiseParams{}.onlyIntensities(), 3);
  EXPECT_TRUE(images_only.poses[5].isApprox(clean.poses[5], 0));
  EXPECT_FALSE(sameImages(images_only, clean));
}

TEST(TestBed, PixelNoiseIsGaussianWithTheGivenSigma) {
  TestBedParams params = smallParams();
  params.num_views = 1;
  const TestBed clean = renderTestBed(bumpySphere(30), params);
  const TestBed noisy = addNoise(clean, NoiseParams{0, 0, 0, 5}, 1);
  double squares = 0, fourth = 0, count = 0;
  for (int y = 0; y < clean.images[0].rows; ++y) {
    for (int x = 0; x < clean.images[0].cols; ++x) {
      const int before = clean.images[0].at<cv::Vec3b>(y, x)[1];
      if (before < 40 || before > 215) continue;
      const double d = noisy.images[0].at<cv::Vec3b>(y, x)[1] - before;
      squares += d * d;
      fourth += d * d * d * d;
      ++count;
    }
  }
  ASSERT_GT(count, 5000);
  EXPECT_NEAR(std::sqrt(squares / count), 5, 0.1);
  EXPECT_NEAR(fourth / count / std::pow(squares / count, 2), 3, 0.3);
}

TEST(TestBed, IsTheSameForAnyNumberOfThreadsAndDiffersBySeed) {
  TestBedParams one = smallParams(), two = smallParams(), other = smallParams();
  one.num_threads = 1;
  two.num_threads = 2;
  other.seed = 2;
  const Mesh mesh = bumpySphere(20);
  const TestBed a = addNoise(renderTestBed(mesh, one), NoiseParams{}, 1, 1);
  const TestBed b = addNoise(renderTestBed(mesh, two), NoiseParams{}, 1, 2);
  EXPECT_TRUE(a.points == b.points);
  EXPECT_TRUE(sameImages(a, b));
  EXPECT_FALSE(renderTestBed(mesh, other).points == a.points);
}

TEST(TestBed, DefaultNoiseMovesTheProjectionsByFivePixels) {
  TestBedParams params = smallParams();
  params.num_views = 48;
  const TestBed bed = renderTestBed(bumpySphere(10), params);
  const TestBed noisy = addNoise(bed, NoiseParams{}, 1);
  EXPECT_EQ(meanReprojectionError(bed, bed.poses), 0);
  EXPECT_NEAR(meanReprojectionError(noisy, noisy.poses), 5 / 4.0, 0.3);  // the images have a quarter of the size
}

TEST(TestBed, ParameterOutOfRangeIsRefused) {
  TestBedParams params = smallParams();
  params.num_points = 0;
  EXPECT_THROW(renderTestBed(bumpySphere(10), params), std::invalid_argument);
  NoiseParams noise;
  noise.gain = 1;
  EXPECT_THROW(addNoise(renderTestBed(bumpySphere(10), smallParams()), noise, 1), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
