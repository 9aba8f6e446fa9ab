// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/camera/camera.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <random>

namespace cloud_colorizer {
namespace {

constexpr double kPi = 3.14159265358979323846;

Intrinsics makeIntrinsics(DistortionModel model, std::vector<double> distortion) {
  return {1280, 800, 650.0, 640.0, 631.5, 408.25, model, std::move(distortion)};
}

std::vector<Intrinsics> someCameras() {
  return {makeIntrinsics(DistortionModel::kPlumbBob, {}),
          makeIntrinsics(DistortionModel::kPlumbBob, {-0.37, 0.2, 0.001, -0.0007, -0.066}),
          makeIntrinsics(DistortionModel::kRationalPolynomial, {0.5, -2.6, 0.001, -0.0004, 1.6, 0.4, -2.4, 1.5}),
          makeIntrinsics(DistortionModel::kEquidistant, {}),
          makeIntrinsics(DistortionModel::kEquidistant, {-0.01, 0.02, -0.01, 0.002})};
}

Eigen::Vector2d oracle(const Intrinsics& in, const Eigen::Vector3d& point) {
  const cv::Matx33d k(in.fx, 0, in.cx, 0, in.fy, in.cy, 0, 0, 1);
  const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
  std::vector<cv::Point2d> pixels;
  std::vector<double> distortion = in.distortion;
  if (in.model == DistortionModel::kEquidistant) {
    distortion.resize(4);
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), k, distortion);
  } else {
    if (distortion.size() < 5) distortion.resize(5);
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k, distortion, pixels);
  }
  return {pixels[0].x, pixels[0].y};
}

Eigen::Vector3d randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> side(-1, 1), depth(0.5, 40);
  const double z = depth(random);
  return {side(random) * z, side(random) * z, z};
}

TEST(Camera, ProjectsAsOpenCvWithinTheFieldOfView) {
  std::mt19937 random(1);
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    int seen = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d point = randomPoint(random);
      const auto pixel = camera.project(point.cast<float>());
      if (!pixel) continue;
      ++seen;
      EXPECT_LT((pixel->cast<double>() - oracle(intrinsics, point)).norm(), 2e-3) << toString(intrinsics.model);
    }
    EXPECT_GT(seen, 500);
  }
}

TEST(Camera, MissesNoPointOfTheImage) {
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    for (double v = 0; v < intrinsics.height; v += 7) {
      for (double u = 0; u < intrinsics.width; u += 7) {
        const auto ray = camera.bearing({u, v});
        if (!ray) continue;
        const auto back = camera.project((*ray * 7).cast<float>());
        ASSERT_TRUE(back) << toString(intrinsics.model) << " " << u << " " << v;
        EXPECT_LT((back->cast<double>() - Eigen::Vector2d(u, v)).norm(), 2e-3);
      }
    }
  }
}

TEST(Camera, BearingInvertsLinearizeToRoundOff) {
  std::mt19937 random(2);
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d point = randomPoint(random);
      const auto at = camera.linearize(point);
      if (!at) continue;
      const auto ray = camera.bearing(at->pixel);
      ASSERT_TRUE(ray);
      EXPECT_LT(ray->cross(point.normalized()).norm(), 1e-9);
    }
  }
}

TEST(Camera, JacobianIsThatOfFiniteDifferences) {
  std::mt19937 random(3);
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d point = i == 0 ? Eigen::Vector3d(0, 0, 2) : randomPoint(random);
      const auto at = camera.linearize(point);
      if (!at) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(axis);
        const auto ahead = camera.linearize(point + step), behind = camera.linearize(point - step);
        if (!ahead || !behind) continue;
        const Eigen::Vector2d slope = (ahead->pixel - behind->pixel) / 2e-5;
        EXPECT_LT((slope - at->jacobian.col(axis)).norm(), 1e-4 * (1 + slope.norm())) << toString(intrinsics.model);
      }
      const auto fast = camera.linearizeUnbounded(point.cast<float>());
      ASSERT_TRUE(fast);
      EXPECT_LT((fast->jacobian.cast<double>() - at->jacobian).norm(), 1e-3 * (1 + at->jacobian.norm()));
      EXPECT_LT((fast->pixel.cast<double>() - at->pixel).norm(), 2e-3);
    }
  }
}

TEST(Camera, PointFarOutsideOfABarrelLensDoesNotFoldBack) {
  const auto intrinsics = makeIntrinsics(DistortionModel::kPlumbBob, {-0.3});
  const Camera camera(intrinsics);
  // d/dr (r - 0.3 r^3) = 0 at r = sqrt(1 / 0.9).
  EXPECT_NEAR(camera.maxAngle(), std::atan(std::sqrt(1 / 0.9)), 1e-9);
  const Eigen::Vector3d outside(1.8, 0, 1);
  const Eigen::Vector2d folded = oracle(intrinsics, outside);
  ASSERT_TRUE(folded.x() > 0 && folded.x() < intrinsics.width);  // OpenCV puts it into the image
  EXPECT_FALSE(camera.project(outside.cast<float>()));
  EXPECT_FALSE(camera.projectUnbounded(outside.cast<float>()));
  EXPECT_FALSE(camera.linearize(outside));
}

TEST(Camera, RationalModelStopsBeforeItsPole) {
  const Camera camera(makeIntrinsics(DistortionModel::kRationalPolynomial, {0, 0, 0, 0, 0, -0.5}));
  EXPECT_LE(camera.maxAngle(), std::atan(std::sqrt(2.0)));
  EXPECT_FALSE(camera.project({3.0F, 0.0F, 1.0F}));
}

TEST(Camera, PointBehindIsRejected) {
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    EXPECT_FALSE(camera.project({0.1F, 0.1F, -2.0F}));
    EXPECT_FALSE(camera.linearize({0.1, 0.1, -2.0}));
    EXPECT_FALSE(camera.project({0.0F, 0.0F, 0.0F}));
  }
}

TEST(Camera, EquidistantSeesBehindItsImagePlane) {
  Intrinsics wide = makeIntrinsics(DistortionModel::kEquidistant, {});
  wide.fx = wide.fy = 200;
  const Camera camera(wide);
  EXPECT_DOUBLE_EQ(camera.maxAngle(), kPi);
  const auto pixel = camera.project({1.0F, 0.0F, -0.2F});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 631.5 + 200 * std::atan2(1.0, -0.2), 1e-3);
}

TEST(Camera, EquidistantStopsWhereItsRadiusStopsGrowing) {
  const Camera camera(makeIntrinsics(DistortionModel::kEquidistant, {-0.2}));
  EXPECT_NEAR(camera.maxAngle(), std::sqrt(1 / 0.6), 1e-9);
  EXPECT_FALSE(camera.bearing({631.5 + 650, 408.25}));  // beyond the largest radius of the model
}

TEST(Camera, PinholeEndsBelowARightAngle) {
  const Camera camera(makeIntrinsics(DistortionModel::kPlumbBob, {}));
  EXPECT_LT(camera.maxAngle(), kPi / 2);
  EXPECT_GT(camera.maxAngle(), kPi / 2 - 0.01);
}

TEST(Camera, MayShowKeepsADiscThatReachesIntoTheImage) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(-4, 4);
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    for (int i = 0; i < 5000; ++i) {
      const Eigen::Vector3f point(uniform(random), uniform(random), uniform(random));
      const Eigen::Vector3f offset = 0.1F * Eigen::Vector3f(uniform(random), uniform(random), uniform(random));
      const bool shows = camera.project(point + offset).has_value();
      EXPECT_TRUE(!shows || camera.mayShow(point, offset.norm() * 1.001F));
      const Camera rolling = camera.whileMoving((Twist() << 0.02, -0.01, 0.03, 0.2, 0.1, -0.3).finished());
      const bool is_shown = rolling.project(point + offset).has_value();
      EXPECT_TRUE(!is_shown || rolling.mayShow(point, offset.norm() * 1.001F));
    }
  }
}

/// The point in the frame of each row's moment: where that shows it in the row itself, it appears.
TEST(Camera, ARollingShutterShowsAPointWhereItsRowSeesIt) {
  std::mt19937 random(5);
  std::normal_distribution<double> turn(0, 0.006), way(0, 0.1);
  for (const auto& intrinsics : someCameras()) {
    const Camera still(intrinsics);
    for (int i = 0; i < 300; ++i) {
      Twist motion;
      for (int k = 0; k < 6; ++k) motion[k] = k < 3 ? turn(random) : way(random);
      const Camera rolling = still.whileMoving(motion);
      const Eigen::Vector3d point = randomPoint(random) + Eigen::Vector3d(0, 0, 2);
      const auto seen = rolling.linearize(point);
      if (!seen) continue;
      const double share = (seen->pixel.y() + 0.5) / intrinsics.height - 0.5;
      const Eigen::Vector3d rotation = share * motion.head<3>();
      const Eigen::AngleAxisd turned(rotation.norm(), rotation.normalized());
      const Eigen::Vector3d at_row = turned.inverse() * (point - share * motion.tail<3>());
      EXPECT_LT((oracle(intrinsics, at_row) - seen->pixel).norm(), 0.1);
      const auto fast = rolling.project(point.cast<float>());
      EXPECT_TRUE(fast && (fast->cast<double>() - seen->pixel).norm() < 0.01);
    }
  }
}

/// Its width times the samples of its border is no int; UBSan tells.
TEST(Camera, LargestImageKeepsItsFieldOfView) {
  Intrinsics intrinsics;
  intrinsics.width = intrinsics.height = 2000000000;
  intrinsics.fx = intrinsics.fy = intrinsics.cx = intrinsics.cy = 1e9;
  const Camera camera(intrinsics);
  for (const float x : {-0.99F, 0.F, 0.99F}) {
    EXPECT_TRUE(camera.mayShow({x, 0, 1}, 0)) << x;
    EXPECT_TRUE(camera.mayShow({0, x, 1}, 0)) << x;
  }
  EXPECT_FALSE(camera.mayShow({1.1F, 0, 1}, 0));
}

TEST(Camera, NumbersThatAreNotFiniteProjectNowhere) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const auto& intrinsics : someCameras()) {
    const Camera camera(intrinsics);
    EXPECT_FALSE(camera.project({nan, 0, 1}));
    EXPECT_FALSE(camera.project({0, 0, nan}));
    EXPECT_FALSE(camera.project({inf, 0, 1}));
    EXPECT_FALSE(camera.bearing({std::nan(""), 0}));
  }
}

TEST(Camera, RefusesAnUncalibratedCamera) {
  Intrinsics intrinsics = makeIntrinsics(DistortionModel::kPlumbBob, {});
  intrinsics.fx = intrinsics.fy = 0;
  EXPECT_THROW(Camera{intrinsics}, std::invalid_argument);
  intrinsics = makeIntrinsics(DistortionModel::kPlumbBob, {});
  intrinsics.height = 0;
  EXPECT_THROW(Camera{intrinsics}, std::invalid_argument);
  intrinsics = makeIntrinsics(DistortionModel::kPlumbBob, {});
  intrinsics.cx = std::nan("");
  EXPECT_THROW(Camera{intrinsics}, std::invalid_argument);
  EXPECT_THROW(Camera{makeIntrinsics(DistortionModel::kPlumbBob, {std::nan("")})}, std::invalid_argument);
}

TEST(Camera, RefusesMoreCoefficientsThanTheModelHas) {
  EXPECT_THROW(Camera{makeIntrinsics(DistortionModel::kEquidistant, {0, 0, 0, 0, 0})}, std::invalid_argument);
  EXPECT_THROW(Camera{makeIntrinsics(DistortionModel::kRationalPolynomial, std::vector<double>(9))},
               std::invalid_argument);
  try {
    const Camera camera(makeIntrinsics(DistortionModel::kPlumbBob, std::vector<double>(8)));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("rational_polynomial"), std::string::npos);
  }
}

TEST(Camera, MissingCoefficientsAreZero) {
  const Camera few(makeIntrinsics(DistortionModel::kPlumbBob, {-0.1, 0.02}));
  const Camera all(makeIntrinsics(DistortionModel::kPlumbBob, {-0.1, 0.02, 0, 0, 0}));
  EXPECT_EQ(*few.project({0.3F, 0.2F, 1.0F}), *all.project({0.3F, 0.2F, 1.0F}));
}

TEST(Camera, ModelNamesGoThereAndBack) {
  for (const auto& in : someCameras()) EXPECT_EQ(distortionModelFromString(toString(in.model)), in.model);
  EXPECT_THROW(distortionModelFromString("fisheye"), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
