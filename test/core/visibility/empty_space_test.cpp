// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/empty_space.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "cloud_colorizer/visibility/depth_image.hpp"

namespace cloud_colorizer {
namespace {

const Eigen::Isometry3f kHere = Eigen::Isometry3f::Identity();

/// Returns from a sphere about the sensor, but for a box in front of it (along x) that is nearer.
Eigen::Matrix3Xd roomWithBox(double room, double box, double step_degrees = 0.25) {
  std::vector<Eigen::Vector3d> returns;
  for (double elevation = -30; elevation <= 30; elevation += step_degrees) {
    for (double azimuth = -180; azimuth < 180; azimuth += step_degrees) {
      const double e = elevation * M_PI / 180, a = azimuth * M_PI / 180;
      const Eigen::Vector3d ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      const bool in_box = std::abs(azimuth) < 10 && std::abs(elevation) < 10;
      returns.push_back((in_box ? box : room) * ray);
    }
  }
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(returns.size()));
  for (std::size_t i = 0; i < returns.size(); ++i) positions.col(static_cast<Eigen::Index>(i)) = returns[i];
  return positions;
}

PlacedScan scanOf(const Eigen::Matrix3Xd& positions, const Eigen::Isometry3f& sensor_from_camera) {
  return {std::make_shared<const ScanRanges>(scanRanges(makeRangePanorama(positions, 0.5, 0))), sensor_from_camera};
}

TEST(RangePanorama, OfNothingKnowsNothing) {
  const cv::Mat1w panorama = makeRangePanorama(Eigen::Matrix3Xd(3, 0), 0.5, 0);
  EXPECT_EQ(panorama.size(), cv::Size(720, 229));
  EXPECT_EQ(cv::countNonZero(panorama), 0);
  EXPECT_EQ(cv::countNonZero(emptyRanges(panorama)), 0);
}

TEST(RangePanorama, KeepsTheNearestFiniteRangeOfADirection) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix3Xd positions(3, 6);
  positions << 20, 10, 0.5, kNaN, 0, 4000,  //
      0, 0, 0, 0, 0, 4000,                  //
      0, 0, 0, 0, 0, 0;
  const cv::Mat1w panorama = makeRangePanorama(positions, 1, 1);
  EXPECT_EQ(cv::countNonZero(panorama), 2);
  double least = 0, greatest = 0;
  cv::minMaxLoc(panorama, nullptr, &greatest);
  cv::minMaxLoc(panorama, &least, nullptr, nullptr, nullptr, panorama > 0);
  EXPECT_EQ(least, 10 * 256);
  EXPECT_EQ(greatest, 65535);  // farther than what 16 bit hold
}

TEST(RangePanorama, RefusesASenselessResolution) {
  EXPECT_THROW(makeRangePanorama(Eigen::Matrix3Xd(3, 0), 0, 0), std::invalid_argument);
  EXPECT_THROW(makeRangePanorama(Eigen::Matrix3Xd(3, 0), std::nan(""), 0), std::invalid_argument);
}

TEST(EmptySpace, EndsShortOfTheNearestReturnAround) {
  EmptySpace space;
  space.add(scanOf(roomWithBox(20, 5), kHere));
  EXPECT_TRUE(space.contains({4.6F, 0, 0}));     // in front of the box
  EXPECT_FALSE(space.contains({4.9F, 0, 0}));    // within the margin
  EXPECT_FALSE(space.contains({12, 0, 0}));      // behind the box
  EXPECT_TRUE(space.contains({-12, 0, 0}));      // across the seam of the panorama
  EXPECT_FALSE(space.contains({-19.5F, 0, 0}));  // 5 % of 20 m
  EXPECT_FALSE(space.contains({0, 0, 12}));      // no return there
  EXPECT_FALSE(space.contains({0, 0, 0}));
  // Beside the box by less than a cell and a half.
  const float angle = 10.4F * static_cast<float>(M_PI) / 180;
  EXPECT_FALSE(space.contains(12 * Eigen::Vector3f(std::cos(angle), std::sin(angle), 0)));
}

TEST(EmptySpace, UncoversWhatItMeasuredBehindWhatItLookedThrough) {
  EmptySpace space;
  space.add(scanOf(roomWithBox(20, 10), kHere));
  const Eigen::Vector3f on_box(10, 0, 0), on_wall(-20, 0, 0), behind_box(20, 0, 0), unknown(0, 0, 12);
  EXPECT_TRUE(space.uncovers(on_box, 9, 0.1F, 0));       // nothing stood a metre before it
  EXPECT_TRUE(space.uncovers(on_wall, 19, 0.1F, 0));     // across the seam of the panorama
  EXPECT_FALSE(space.uncovers(on_box, 9.95F, 0.1F, 0));  // too near to it to tell
  EXPECT_FALSE(space.uncovers(behind_box, 15, 0.1F, 0));
  EXPECT_FALSE(space.uncovers(behind_box, 10, 0.1F, 0));
  EXPECT_FALSE(space.uncovers(unknown, 5, 0.1F, 0));
  space.add(scanOf(roomWithBox(20, 5), kHere));  // which has it otherwise
  EXPECT_FALSE(space.uncovers(on_box, 9, 0.1F, 0));
}

TEST(EmptySpace, AgreesWithTheRoomInEveryDirection) {
  EmptySpace space;
  Eigen::Isometry3f sensor_from_camera(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, 3).normalized()));
  sensor_from_camera.translation() << 0.3F, -0.2F, 0.5F;
  space.add(scanOf(roomWithBox(20, 20), sensor_from_camera));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> angle(-3.14F, 3.14F), up(-0.45F, 0.45F), range(1, 30);
  for (int i = 0; i < 10000; ++i) {
    const float a = angle(random), z = up(random), r = range(random);
    if (r > 18.5F && r < 19.5F) continue;
    const Eigen::Vector3f place = r * Eigen::Vector3f(std::cos(a), std::sin(a), z).normalized();
    EXPECT_EQ(space.contains(sensor_from_camera.inverse() * place), r < 19) << place.transpose();
  }
}

TEST(EmptySpace, AScanThatSawSomethingThereObjects) {
  EmptySpace space;
  space.add(scanOf(roomWithBox(20, 20), kHere));
  EXPECT_TRUE(space.contains({5.2F, 0, 0}));
  space.add(scanOf(roomWithBox(20, 5), kHere));
  EXPECT_FALSE(space.contains({5.2F, 0, 0}));
  EXPECT_TRUE(space.contains({0, 5.2F, 0}));
}

TEST(EmptySpace, WhatWasNotThereNeitherHidesNorIsSeen) {
  const Camera camera({100, 80, 100, 100, 49.5, 39.5, DistortionModel::kPlumbBob, {}});
  // The camera looks along the sensor's x; the map has a ghost at 3 m where the scan saw the wall at 10 m.
  Eigen::Isometry3f sensor_from_camera = kHere;
  sensor_from_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  auto space = std::make_shared<EmptySpace>();
  space->add(scanOf(roomWithBox(10, 10), sensor_from_camera));
  Points ghost(3, 1);
  ghost << 0, 0, 3;
  const Surfels surfel{Eigen::Vector3f(0, 0, -1), Eigen::VectorXf::Constant(1, 0.5F), Eigen::VectorXf::Zero(1)};
  const auto depthWith = [&](const std::shared_ptr<const EmptySpace>& empty_space) {
    DepthSplatter splatter(camera, kHere, DepthParams{}, empty_space);
    splatter.add(ghost, surfel);
    return splatter.finish();
  };
  const Eigen::Vector2f pixel(49.5F, 39.5F);
  const Eigen::Vector3f wall(0, 0, 9.9F), normal(0, 0, -1);
  const DepthImage without = depthWith(nullptr), with = depthWith(space);
  EXPECT_EQ(without.test(pixel, wall, normal, 0.05F, {}), Visibility::kHidden);
  EXPECT_EQ(without.test(pixel, ghost.col(0), normal, 0.05F, {}), Visibility::kVisible);
  EXPECT_EQ(with.test(pixel, wall, normal, 0.05F, {}), Visibility::kVisible);
  EXPECT_EQ(with.test(pixel, ghost.col(0), normal, 0.05F, {}), Visibility::kAbsent);
}

}  // namespace
}  // namespace cloud_colorizer
