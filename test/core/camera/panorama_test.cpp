// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/panorama.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace cloud_colorizer {
namespace {

/// A smooth colour of each direction.
cv::Vec3b colorOf(const Eigen::Vector3d& ray) {
  const Eigen::Vector3d unit = ray.normalized();
  return {static_cast<std::uint8_t>(128 + 100 * std::sin(6 * unit.x() + 2 * unit.z())),
          static_cast<std::uint8_t>(128 + 100 * std::sin(5 * unit.y() - unit.x())),
          static_cast<std::uint8_t>(128 + 100 * std::sin(7 * unit.z()))};
}

Eigen::Vector3d rayOf(double u, double v, cv::Size size) {
  const double around = 2 * M_PI * ((u + 0.5) / size.width - 0.5), below = M_PI * ((v + 0.5) / size.height - 0.5);
  return {std::sin(around) * std::cos(below), std::sin(below), std::cos(around) * std::cos(below)};
}

TEST(Panorama, FacesShowWhatTheirCamerasWouldSee) {
  const cv::Size size(800, 400);
  cv::Mat3b panorama(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) panorama(v, u) = colorOf(rayOf(u, v, size));
  }
  const auto faces = panoramaFaces(size.width);
  ASSERT_EQ(faces.size(), 6U);
  for (const PanoramaFace& face : faces) {
    EXPECT_NEAR(face.panorama_from_face.determinant(), 1, 1e-12) << face.name;
    const cv::Mat3b image = cutFace(panorama, face);
    const Camera camera(face.intrinsics);
    int most = 0;
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const cv::Vec3b expected = colorOf(face.panorama_from_face * *camera.bearing({u, v}));
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(int{image(v, u)[c]} - int{expected[c]}));
      }
    }
    EXPECT_LE(most, 3) << face.name;
  }
}

TEST(Panorama, EveryDirectionIsInAFaceBeyondItsBorder) {
  const auto faces = panoramaFaces(640);
  std::vector<Camera> cameras;
  for (const PanoramaFace& face : faces) cameras.emplace_back(face.intrinsics);
  const double last = faces[0].intrinsics.width - 1 - 3;  // 3 px at the border are not used
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d ray = Eigen::Vector3d::Random();
    bool is_seen = false;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const auto pixel = cameras[f].project((faces[f].panorama_from_face.transpose() * ray).cast<float>());
      is_seen = is_seen || (pixel && pixel->minCoeff() >= 3 && pixel->maxCoeff() <= static_cast<float>(last));
    }
    ASSERT_TRUE(is_seen) << ray.transpose();
  }
}

TEST(Panorama, ItsMaskIsCutAsWell) {
  cv::Mat1b mask(200, 400, std::uint8_t{255});
  mask(cv::Rect(0, 160, 400, 40)).setTo(0);  // the vehicle below
  const auto faces = panoramaFaces(400);
  const cv::Mat1b down = cutMask(mask, faces[5]), front = cutMask(mask, faces[0]);
  EXPECT_EQ(down(down.rows / 2, down.cols / 2), 0);
  EXPECT_EQ(front(front.rows / 2, front.cols / 2), 255);
  EXPECT_TRUE(cutMask({}, faces[0]).empty());
}

TEST(Panorama, OnlyThoseTwiceAsWideAsHighAreSome) {
  EXPECT_NO_THROW(checkPanorama({400, 200}));
  EXPECT_THROW(checkPanorama({400, 300}), std::invalid_argument);
  Intrinsics panorama;
  panorama.width = 400;
  panorama.height = 200;
  panorama.model = DistortionModel::kEquirectangular;
  EXPECT_THROW(Camera{panorama}, std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
