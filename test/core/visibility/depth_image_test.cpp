// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/depth_image.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>
#include <random>

namespace cloud_colorizer {
namespace {

const Camera kCamera({640, 400, 325, 325, 319.5, 199.5, DistortionModel::kPlumbBob, {}});
const Eigen::Isometry3f kHere = Eigen::Isometry3f::Identity();
const DepthParams kParams;

struct Patch {
  Points points;
  Surfels surfels;
};

/// A grid of exact surfels: corner + i a + j b.
Patch makePatch(const Eigen::Vector3f& corner, const Eigen::Vector3f& a, int rows, const Eigen::Vector3f& b, int cols) {
  Patch patch{Points(3, rows * cols), {}};
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < cols; ++j) {
      patch.points.col(i * cols + j) = corner + static_cast<float>(i) * a + static_cast<float>(j) * b;
    }
  }
  patch.surfels.normals = a.cross(b).normalized().replicate(1, rows * cols);
  patch.surfels.radii = Eigen::VectorXf::Constant(rows * cols, std::max(a.norm(), b.norm()));
  return patch;
}

Patch wallAt(float z, float left, float right) {
  const float step = 0.05F;
  return makePatch({left, -6, z}, {step, 0, 0}, static_cast<int>((right - left) / step), {0, step, 0}, 240);
}

Patch groundBelow(float height) {
  return makePatch({-8, height, 1.5F}, {0.05F, 0, 0}, 320, {0, 0, 0.05F}, 700);
}

DepthImage render(const std::vector<Patch>& patches, const DepthParams& params = kParams) {
  DepthSplatter splatter(kCamera, kHere, params);
  for (const Patch& patch : patches) splatter.add(patch.points, patch.surfels);
  return splatter.finish();
}

Eigen::Vector3f rayOfCell(const DepthImage& image, int row, int col) {
  const auto pixel = [&](int cell) { return (cell + 0.5) * static_cast<double>(image.cell_size) - 0.5; };
  return kCamera.bearing({pixel(col), pixel(row)})->cast<float>();
}

TEST(Depth, OfNothingIsInfinite) {
  const DepthImage image = render({});
  EXPECT_EQ(image.depth.size(), cv::Size(320, 200));
  EXPECT_EQ(cv::countNonZero(image.depth == std::numeric_limits<float>::infinity()), 320 * 200);
  EXPECT_EQ(cv::countNonZero(image.edge), 0);
}

TEST(Depth, OfAWallIsExactAndWithoutHoles) {
  const DepthImage image = render({wallAt(4, -6, 6)});
  for (int row = 0; row < image.depth.rows; ++row) {
    for (int col = 0; col < image.depth.cols; ++col) {
      EXPECT_NEAR(image.depth(row, col), 4 / rayOfCell(image, row, col).z(), 0.01);
    }
  }
  EXPECT_EQ(cv::countNonZero(image.edge), 0);
}

TEST(Depth, OfGrazingGroundIsTheNearestWithinTheCell) {
  const DepthImage image = render({groundBelow(1.7F)});
  for (int row = 110; row < 199; row += 3) {
    for (int col = 100; col < 220; col += 3) {
      const Eigen::Vector3f ray = rayOfCell(image, row, col), below = rayOfCell(image, row + 1, col);
      const float truth = 1.7F / ray.y(), nearer = 1.7F / below.y();
      if (truth > 30 || truth < 3 || std::abs(truth * ray.x()) > 7) continue;
      EXPECT_LT(image.depth(row, col), truth + 0.1F);
      EXPECT_GT(image.depth(row, col), nearer - 0.1F);
    }
  }
}

TEST(Depth, GrazingGroundHasNoEdges) {
  const DepthImage image = render({groundBelow(1.7F)});
  EXPECT_EQ(cv::countNonZero(image.edge(cv::Rect(120, 110, 80, 80))), 0);
}

TEST(Depth, DoesNotDependOnTheOrder) {
  Patch wall = wallAt(4, -6, 0.5F), ground = groundBelow(1.7F);
  const DepthImage forward = render({wall, ground});
  wall.points = wall.points.rowwise().reverse().eval();
  const DepthImage backward = render({ground, wall});
  EXPECT_EQ(cv::norm(forward.depth == backward.depth, cv::Mat1b(forward.depth.size(), 255), cv::NORM_INF), 0);
}

TEST(Depth, EdgeBandLiesOnBothSidesOfARim) {
  const DepthImage image = render({wallAt(4, -6, 0), wallAt(8, -12, 12)});
  const int rim = 160, row = 100;  // x = 0 lies in the middle column
  EXPECT_NE(image.edge(row, rim - 1), 0);
  EXPECT_NE(image.edge(row, rim + 1), 0);
  EXPECT_EQ(image.edge(row, rim - 12), 0);
  EXPECT_EQ(image.edge(row, rim + 12), 0);
  DepthParams without;
  without.depth_edge_guard = 0;
  EXPECT_EQ(cv::countNonZero(render({wallAt(4, -6, 0), wallAt(8, -12, 12)}, without).edge), 0);
}

TEST(Depth, SkyBesideASurfaceIsAnEdge) {
  const DepthImage image = render({wallAt(4, -6, 0)});
  EXPECT_NE(image.edge(100, 158), 0);
  EXPECT_EQ(image.edge(100, 140), 0);
}

TEST(Depth, SurfelsAtTheCameraDoNotFillTheImage) {
  for (const float z : {-0.02F, 0.0F, 1e-6F, 0.01F, 0.05F}) {
    for (const Eigen::Vector3f& normal :
         {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 0, 1)}) {
      Patch patch{Eigen::Vector3f(0, 0, z), {normal, Eigen::VectorXf::Constant(1, 0.1F), {}}};
      const DepthImage image = render({patch});
      const int covered = cv::countNonZero(image.depth < 1e9F);
      EXPECT_LT(covered, 320 * 200 / 10);
      EXPECT_EQ(cv::countNonZero(image.depth != image.depth), 0);
    }
  }
}

TEST(Depth, EverySurfelInTheImageCoversItsCell) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> side(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const float z = 20 + 15 * side(random);
    const Eigen::Vector3f point(0.9F * z * side(random), 0.5F * z * side(random), z);
    const Eigen::Vector3f normal = Eigen::Vector3f(side(random), side(random), side(random)).normalized();
    const auto pixel = kCamera.project(point);
    if (!pixel || point.norm() > 40) continue;
    Patch patch{point, {normal, Eigen::VectorXf::Constant(1, 0.01F), {}}};
    EXPECT_EQ(render({patch}).test(*pixel, point, normal, 0.01F, kParams), Visibility::kEdge);
  }
}

TEST(Depth, WhatIsBehindAWallIsHiddenAndWhatIsOnItIsNot) {
  const DepthImage image = render({wallAt(4, -6, 6)});
  const Eigen::Vector3f facing(0, 0, 1);
  for (const float z : {3.9F, 4.0F, 4.01F}) {
    EXPECT_EQ(image.test({319.5F, 199.5F}, {0, 0, z}, facing, 0.05F, kParams), Visibility::kVisible) << z;
  }
  for (const float z : {4.3F, 10.0F}) {
    EXPECT_EQ(image.test({319.5F, 199.5F}, {0, 0, z}, facing, 0.05F, kParams), Visibility::kHidden) << z;
  }
}

TEST(Depth, WallHidesWhatStandsEdgeOnBehindIt) {
  const DepthImage image = render({wallAt(4, -6, 6)});
  EXPECT_EQ(image.test({319.5F, 199.5F}, {0, 0, 4.4F}, {1, 0, 0}, 0.05F, kParams), Visibility::kHidden);
}

TEST(Depth, OutsideOfTheImageIsHidden) {
  const DepthImage image = render({});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Eigen::Vector2f& pixel :
       {Eigen::Vector2f(-1, 5), Eigen::Vector2f(640, 5), Eigen::Vector2f(5, 400), Eigen::Vector2f(nan, 5)}) {
    EXPECT_EQ(image.test(pixel, {0, 0, 4}, {0, 0, 1}, 0.05F, kParams), Visibility::kHidden);
  }
}

TEST(Depth, FisheyeSeesSurfacesBesideAndBehind) {
  const Camera fisheye({600, 600, 150, 150, 299.5, 299.5, DistortionModel::kEquidistant, {}});
  Patch wall = makePatch({2, -1, -1.5F}, {0, 0.05F, 0}, 40, {0, 0, 0.05F}, 60);  // the plane x = 2, across z = 0
  DepthSplatter splatter(fisheye, kHere, kParams);
  splatter.add(wall.points, wall.surfels);
  const DepthImage image = splatter.finish();
  for (const float z : {-0.5F, 0.0F, 1.0F}) {
    const Eigen::Vector3f on(2, 0, z), beyond = 1.2F * on, normal(1, 0, 0);
    EXPECT_EQ(image.test(*fisheye.project(on), on, normal, 0.05F, kParams), Visibility::kVisible) << z;
    EXPECT_EQ(image.test(*fisheye.project(beyond), beyond, normal, 0.05F, kParams), Visibility::kHidden) << z;
  }
}

TEST(Depth, ViewsReachTwoThirdsOfTheRangeOfTheScanner) {
  DepthParams params;
  EXPECT_EQ(params.reach(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(params.reach(60), 40);
  params.max_view_distance = 5;
  EXPECT_EQ(params.reach(60), 5);
}

TEST(Depth, ParametersOutOfRangeAreRefused) {
  for (const auto field : {&DepthParams::depth_cell_size, &DepthParams::depth_tolerance, &DepthParams::depth_edge_guard,
                           &DepthParams::max_view_distance}) {
    DepthParams params;
    params.*field = -1;
    EXPECT_THROW(DepthSplatter(kCamera, kHere, params), std::invalid_argument);
    params.*field = std::nan("");
    EXPECT_THROW(params.check(), std::invalid_argument);
  }
}

}  // namespace
}  // namespace cloud_colorizer
