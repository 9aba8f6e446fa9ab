// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surface/surfels.hpp"

#include <gtest/gtest.h>
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <limits>
#include <random>

#include "core/pcl_points.hpp"
#include "core/street_scene.hpp"

namespace cloud_colorizer {
namespace {

const SurfelParams kParams;

/// A square of the plane z = 0, 5 cm voxels, with noise along z.
test::Scan noisyPlane(double noise) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(-1, 1);
  std::normal_distribution<double> normal(0, noise);
  test::Thinner thinner(0.05);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d truth(side(random), side(random), 0);
    thinner.add(truth + Eigen::Vector3d(0, 0, noise > 0 ? normal(random) : 0), truth);
  }
  return thinner.finish();
}

void expectSane(const Points& points, const Surfels& surfels) {
  ASSERT_EQ(surfels.normals.cols(), points.cols());
  ASSERT_EQ(surfels.radii.size(), points.cols());
  EXPECT_TRUE(surfels.normals.allFinite() && surfels.radii.allFinite() && surfels.offsets.allFinite());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const float norm = surfels.normals.col(i).norm();
    EXPECT_TRUE(norm == 0 || std::abs(norm - 1) < 1e-3) << norm;
    EXPECT_GE(surfels.radii[i], 0);
  }
}

TEST(Surfels, NoPointsGiveNoSurfels) {
  EXPECT_EQ(estimateSurfels(Points(3, 0), kParams).radii.size(), 0);
}

TEST(Surfels, FewOrEqualPointsAreHandled) {
  for (const int count : {1, 2, 3, 100}) {
    const Points same = Points::Constant(3, count, 7.5F);
    expectSane(same, estimateSurfels(same, kParams));
    const Points line = Eigen::Vector3f(1, 2, 3) * Eigen::RowVectorXf::LinSpaced(count, 0, 1);
    const Surfels surfels = estimateSurfels(line, kParams);
    expectSane(line, surfels);
    EXPECT_TRUE(surfels.normals.isZero());  // a line has no plane
  }
}

TEST(Surfels, NormalsOfANoisyPlaneAreItsOwn) {
  const test::Scan scan = noisyPlane(0.02);
  const Surfels surfels = estimateSurfels(scan.points, kParams);
  expectSane(scan.points, surfels);
  int flat = 0;
  double squared_sine = 0;
  for (Eigen::Index i = 0; i < scan.points.cols(); ++i) {
    const Eigen::Vector3f normal = surfels.normals.col(i);
    if (normal.isZero()) continue;
    ++flat;
    squared_sine += normal.head<2>().squaredNorm();
  }
  EXPECT_GT(flat, 0.95 * static_cast<double>(scan.points.cols()));
  EXPECT_LT(std::sqrt(squared_sine / flat), 0.15);
}

/// Median angle between our normals and those of PCL, deg.
double medianAngleToPcl(const Points& points) {
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(test::pclPoints(points));
  estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  estimation.setKSearch(kParams.num_neighbors);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  const Surfels surfels = estimateSurfels(points, kParams);
  std::vector<double> angles;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f normal = surfels.normals.col(i);
    if (normal.isZero()) continue;
    const Eigen::Vector3f other = normals[static_cast<std::size_t>(i)].getNormalVector3fMap();
    angles.push_back(std::acos(std::min(1.0F, std::abs(normal.dot(other)))) * 180 / M_PI);
  }
  EXPECT_GT(static_cast<double>(angles.size()), 0.95 * static_cast<double>(points.cols()));
  std::nth_element(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2), angles.end());
  return angles[angles.size() / 2];
}

TEST(Surfels, NormalsAreThoseOfPcl) {
  std::mt19937 random(3);
  std::normal_distribution<float> gauss;
  Points sphere(3, 3000);
  for (Eigen::Index i = 0; i < sphere.cols(); ++i) {
    sphere.col(i) = Eigen::Vector3f(gauss(random), gauss(random), gauss(random)).normalized();
  }
  EXPECT_LT(medianAngleToPcl(sphere), 2);
  EXPECT_LT(medianAngleToPcl(noisyPlane(0).points), 0.1);
  EXPECT_LT(medianAngleToPcl(noisyPlane(0.005).points), 2);
}

TEST(Surfels, OffsetsThinTheSlab) {
  const test::Scan scan = noisyPlane(0.02);
  const Surfels surfels = estimateSurfels(scan.points, kParams);
  double before = 0, after = 0;
  for (Eigen::Index i = 0; i < scan.points.cols(); ++i) {
    before += std::pow(scan.points(2, i), 2);
    after += std::pow(surfels.onSurface(i, scan.points.col(i)).z(), 2);
  }
  EXPECT_LT(after, before / 9);  // a third of the thickness
}

TEST(Surfels, CurvedSurfaceKeepsItsSize) {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  Points sphere(3, 3000);
  for (Eigen::Index i = 0; i < sphere.cols(); ++i) {
    sphere.col(i) = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
  }
  const Surfels surfels = estimateSurfels(sphere, kParams);
  double sum = 0;
  for (Eigen::Index i = 0; i < sphere.cols(); ++i) sum += 1 - surfels.onSurface(i, sphere.col(i)).norm();
  const double spacing = std::sqrt(4 * M_PI / 3000);
  // Planes through the neighbours lie 0.18 spacings too deep: what a bend without tilt leaves of it.
  EXPECT_LT(std::abs(sum / 3000), 0.03 * spacing);
}

TEST(Surfels, DiscsCloseTheSurface) {
  for (const double noise : {0.0, 0.02}) {
    const test::Scan scan = noisyPlane(noise);
    const Surfels surfels = estimateSurfels(scan.points, kParams);
    std::mt19937 random(2);
    std::uniform_real_distribution<float> side(-0.9F, 0.9F);
    int open = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2f place(side(random), side(random));
      const auto distances = (scan.points.topRows<2>().colwise() - place).colwise().norm();
      open += !(distances.transpose().array() <= surfels.radii.array()).any();
    }
    EXPECT_LT(open, 10);
    EXPECT_LT(surfels.radii.mean(), 0.07);  // about a voxel
  }
}

TEST(Surfels, ScanLinesOfAWallStillGiveItsPlane) {
  Points points(3, 10 * 200);
  for (int line = 0; line < 10; ++line) {
    for (int i = 0; i < 200; ++i) {
      points.col(line * 200 + i) = Eigen::Vector3f(0.01F * static_cast<float>(i), 5, 0.15F * static_cast<float>(line));
    }
  }
  const Surfels surfels = estimateSurfels(points, kParams);
  expectSane(points, surfels);
  int good = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    good += std::abs(surfels.normals(1, i)) > 0.99F && surfels.radii[i] > 0.07F && surfels.radii[i] < 0.5F;
  }
  EXPECT_GT(good, 0.9 * static_cast<double>(points.cols()));
}

TEST(Surfels, FarOutlierStaysSmall) {
  test::Scan scan = noisyPlane(0);
  scan.points.col(0) = Eigen::Vector3f(0, 0, 0.8F);
  EXPECT_LT(estimateSurfels(scan.points, kParams).radii[0], 0.5F);
}

/// A square of side 2 m whose points scatter about their layers, which lie `gap` apart. Their median thickness.
float thicknessOfLayers(float noise, float gap) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> side(-1, 1);
  std::normal_distribution<float> normal(0, noise);
  Points points(3, 60000);  // spacing 8 mm
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    points.col(i) << side(random), side(random), normal(random) + (i % 2 == 0 ? gap : 0);
  }
  Eigen::VectorXf sorted = estimateSurfels(points, kParams).thicknesses;
  std::nth_element(sorted.data(), sorted.data() + sorted.size() / 2, sorted.data() + sorted.size());
  return sorted[sorted.size() / 2];
}

TEST(Surfels, ThicknessIsWhatAveragingLeavesOfTheNoise) {
  for (const float noise : {0.01F, 0.02F}) {
    const float thickness = thicknessOfLayers(noise, 0);
    EXPECT_GT(thickness, 0.4F * noise);
    EXPECT_LT(thickness, 0.6F * noise);
  }
}

TEST(Surfels, LayersAreHalfTheirGapThick) {
  for (const float gap : {0.04F, 0.08F}) EXPECT_NEAR(thicknessOfLayers(0.003F, gap), gap / 2, 0.1F * gap);
}

TEST(Surfels, PointGivenManyTimesIsOnePoint) {
  const Points once = noisyPlane(0.02).points;
  Points thrice(3, 3 * once.cols());
  thrice << once, once, once;
  const Surfels alone = estimateSurfels(once, kParams), together = estimateSurfels(thrice, kParams);
  for (const int copy : {0, 1, 2}) {
    EXPECT_EQ(alone.normals, together.normals.middleCols(copy * once.cols(), once.cols()));
    EXPECT_EQ(alone.radii, together.radii.segment(copy * once.cols(), once.cols()));
    EXPECT_EQ(alone.offsets, together.offsets.segment(copy * once.cols(), once.cols()));
    EXPECT_EQ(alone.thicknesses, together.thicknesses.segment(copy * once.cols(), once.cols()));
  }
}

TEST(Surfels, ScaleOfTheSceneDoesNotMatter) {
  const Points points = noisyPlane(0.02).points;
  const Surfels surfels = estimateSurfels(points, kParams);
  for (const float scale : {1.F / 128, 128.F}) {  // powers of two: exact in floats
    const Surfels scaled = estimateSurfels(scale * points, kParams);
    EXPECT_EQ(scaled.normals, surfels.normals);
    EXPECT_EQ(scaled.radii, scale * surfels.radii);
    EXPECT_EQ(scaled.thicknesses, scale * surfels.thicknesses);
  }
}

TEST(Surfels, PieceHasTheSurfelsOfTheWhole) {
  const Points points = noisyPlane(0.02).points;
  const ZOrderGrid grid{Eigen::Vector3f::Constant(-2), 1.F / 1024};
  constexpr int kLevel = 8;  // cells of up to 0.25 m
  const Surfels whole = estimateSurfels(points, points.cols(), grid, kLevel, kParams);
  std::vector<Eigen::Index> own, beside;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (points(0, i) < 0)
      own.push_back(i);
    else if (points(0, i) < 0.5F)
      beside.push_back(i);
  }
  std::vector<Eigen::Index> all = own;
  all.insert(all.end(), beside.begin(), beside.end());
  Points piece(3, static_cast<Eigen::Index>(all.size()));
  for (std::size_t k = 0; k < all.size(); ++k) piece.col(static_cast<Eigen::Index>(k)) = points.col(all[k]);
  const auto count = static_cast<Eigen::Index>(own.size());
  const Surfels part = estimateSurfels(piece, count, grid, kLevel, kParams);
  ASSERT_EQ(part.radii.size(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index i = own[static_cast<std::size_t>(k)];
    EXPECT_EQ(part.normals.col(k), whole.normals.col(i));
    EXPECT_EQ(part.radii[k], whole.radii[i]);
    EXPECT_EQ(part.thicknesses[k], whole.thicknesses[i]);
  }
}

TEST(Surfels, RefusesBadInput) {
  Points points = Points::Random(3, 20);
  points(1, 7) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(estimateSurfels(points, kParams), std::invalid_argument);
  SurfelParams params;
  params.num_neighbors = 2;
  EXPECT_THROW(estimateSurfels(Points(3, 0), params), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
