// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/picture/picture.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace cloud_colorizer {
namespace {

PictureParams smallPicture() {
  PictureParams params;
  params.width = 64;
  params.height = 48;
  params.point_size = 0.2;
  return params;
}

/// One point straight ahead at each of the given distances, with these colours.
ColoredPoints pointsAhead(const std::vector<float>& distances, const Values& colors) {
  Points points(3, static_cast<Eigen::Index>(distances.size()));
  for (std::size_t i = 0; i < distances.size(); ++i) points.col(static_cast<Eigen::Index>(i)) << distances[i], 0, 0;
  return [=](const std::function<void(PointsRef, ValuesRef)>& visit) { visit(points, colors); };
}

const Eigen::Isometry3d kAlongX = lookAt(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX());

TEST(Picture, LookAtMakesAnOpticalFrameWithTheSkyAbove) {
  EXPECT_TRUE((kAlongX * Eigen::Vector3d(0, 0, 2)).isApprox(Eigen::Vector3d(2, 0, 0)));   // z: forward
  EXPECT_TRUE((kAlongX * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, -1, 0)));  // x: right
  EXPECT_TRUE((kAlongX * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, 0, -1)));  // y: down
  EXPECT_NEAR(kAlongX.linear().determinant(), 1, 1e-12);
  EXPECT_THROW(lookAt(Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones()), std::invalid_argument);
  EXPECT_TRUE(lookAt({0, 0, 5}, {0, 0, 0}).matrix().allFinite());
}

TEST(Picture, LookAtTakesAnotherDirectionUpwards) {
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitZ(), up = -2 * Eigen::Vector3d::UnitY();  // a camera's own frame
  EXPECT_TRUE(lookAt(Eigen::Vector3d::Zero(), forward, up).isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(lookAt(Eigen::Vector3d::Zero(), up, up).matrix().allFinite());
  EXPECT_TRUE(lookAt({0, 0, 5}, {0, 0, 0}).linear().col(1).isApprox(-Eigen::Vector3d::UnitX()));
  EXPECT_THROW(lookAt(Eigen::Vector3d::Zero(), forward, Eigen::Vector3d::Zero()), std::invalid_argument);
}

TEST(Picture, NothingShowsTheBackground) {
  const cv::Mat picture = drawPicture(pointsAhead({}, Values(3, 0)), kAlongX, smallPicture());
  ASSERT_EQ(picture.size(), cv::Size(64, 48));
  EXPECT_EQ(picture.at<cv::Vec3b>(24, 32), cv::Vec3b(228, 216, 203));
}

TEST(Picture, NearerPointsHideFartherOnes) {
  Values colors(3, 2);
  colors << 255, 0, 0, 255, 0, 0;
  const cv::Mat picture = drawPicture(pointsAhead({2, 4}, colors), kAlongX, smallPicture());
  EXPECT_EQ(picture.at<cv::Vec3b>(24, 32), cv::Vec3b(0, 0, 255));
}

TEST(Picture, PointsOfOneSurfaceBlend) {
  Values colors(3, 2);
  colors << 200, 0, 0, 0, 0, 200;
  const cv::Mat picture = drawPicture(pointsAhead({2, 2.01F}, colors), kAlongX, smallPicture());
  const cv::Vec3b color = picture.at<cv::Vec3b>(24, 32);
  EXPECT_NEAR(color[0], 100, 5);
  EXPECT_NEAR(color[2], 100, 5);
}

TEST(Picture, PointsBehindAndNaNAreNotDrawn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat picture = drawPicture(pointsAhead({-2, nan}, Values::Zero(3, 2)), kAlongX, smallPicture());
  EXPECT_EQ(picture.at<cv::Vec3b>(24, 32), cv::Vec3b(228, 216, 203));
}

TEST(Picture, ScaleGoesFromDarkToBrightAndMarksWhatIsNoNumber) {
  Eigen::VectorXf numbers(4);
  numbers << 0, 10, -1, std::numeric_limits<float>::quiet_NaN();
  const Values colors = colorScale(numbers, 0, 10);
  EXPECT_LT(colors.col(0).sum(), colors.col(1).sum());
  EXPECT_EQ(colors.col(2), Eigen::Vector3f::Constant(128));
  EXPECT_EQ(colors.col(3), Eigen::Vector3f::Constant(128));
}

TEST(Picture, SideBySideIsAsWideAsAllTogether) {
  const cv::Mat picture(48, 64, CV_8UC3);
  EXPECT_GE(besideEachOther({picture, picture}, {"a", "b"}).cols, 128);
  EXPECT_TRUE(besideEachOther({}, {}).empty());
}

TEST(Picture, RefusesBadParameters) {
  PictureParams params = smallPicture();
  params.point_size = 0;
  EXPECT_THROW(params.check(), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
