// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/colmap.hpp"

#include <gtest/gtest.h>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

void writeModel(const ScratchDirectory& scratch, const std::string& cameras, const std::string& images) {
  writeText(scratch / "cameras.txt", cameras);
  writeText(scratch / "images.txt", images);
}

const char* const kCamera = "1 PINHOLE 640 480 500 501 320 240\n";

TEST(Colmap, EmptyModelIsEmpty) {
  ScratchDirectory scratch;
  writeModel(scratch, "# nothing\n", "");
  const auto model = readColmapModel(scratch.path());
  EXPECT_TRUE(model.cameras.empty() && model.images.empty());
}

TEST(Colmap, PrincipalPointMovesByHalfAPixel) {
  ScratchDirectory scratch;
  writeModel(scratch, kCamera, "");
  const auto camera = readColmapModel(scratch.path()).cameras.at(0);
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 500);
  EXPECT_EQ(camera.fy, 501);
  EXPECT_EQ(camera.cx, 319.5);
  EXPECT_EQ(camera.cy, 239.5);
}

TEST(Colmap, EveryModelBecomesOurs) {
  ScratchDirectory scratch;
  writeModel(scratch,
             "9 OPENCV_FISHEYE 64 48 50 51 32 24 .01 .002 .003 .004\n"
             "2 SIMPLE_PINHOLE 64 48 50 32 24\n"
             "3 SIMPLE_RADIAL 64 48 50 32 24 .1\n"
             "4 RADIAL 64 48 50 32 24 .1 .02\n"
             "5 OPENCV 64 48 50 51 32 24 .1 .02 .003 .004\n"
             "6 FULL_OPENCV 64 48 50 51 32 24 .1 .02 .003 .004 .005 .006 .007 .008\n",
             "");
  const auto cameras = readColmapModel(scratch.path()).cameras;
  ASSERT_EQ(cameras.size(), 6U);
  EXPECT_TRUE(cameras[0].distortion.empty());
  EXPECT_EQ(cameras[0].fy, 50);
  EXPECT_EQ(cameras[1].distortion, (std::vector<double>{.1, 0, 0, 0}));
  EXPECT_EQ(cameras[2].distortion, (std::vector<double>{.1, .02, 0, 0}));
  EXPECT_EQ(cameras[3].distortion, (std::vector<double>{.1, .02, .003, .004}));
  EXPECT_EQ(cameras[3].model, DistortionModel::kPlumbBob);
  EXPECT_EQ(cameras[4].distortion, (std::vector<double>{.1, .02, .003, .004, .005, .006, .007, .008}));
  EXPECT_EQ(cameras[4].model, DistortionModel::kRationalPolynomial);
  EXPECT_EQ(cameras[5].distortion, (std::vector<double>{.01, .002, .003, .004}));
  EXPECT_EQ(cameras[5].model, DistortionModel::kEquidistant);
}

TEST(Colmap, PosesAreInvertedAndOrderedByIdAndNamesMayHaveSpaces) {
  ScratchDirectory scratch;
  // A quarter turn about z; the camera's centre is -R^T t = (-2, 1, -3).
  writeModel(scratch, kCamera,
             "# comment\n7 1 0 0 0 0 0 0 1 last.jpg\n1 2 3 4 5 6\n"
             "2 0.70710678118654752 0 0 0.70710678118654752 1 2 3 1 a dir/first image.jpg");
  const auto images = readColmapModel(scratch.path()).images;
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].name, "a dir/first image.jpg");
  EXPECT_EQ(images[1].name, "last.jpg");
  EXPECT_LT((images[0].map_from_camera.translation() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12);
  EXPECT_LT((images[0].map_from_camera.linear() * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(Colmap, RoundTripKeepsEverything) {
  ScratchDirectory scratch;
  ColmapModel model;
  model.cameras = {{640, 480, 500.1, 501.2, 319.25, 240.75, DistortionModel::kPlumbBob, {}},
                   {64, 48, 50, 51, 31, 23, DistortionModel::kPlumbBob, {.1, -.02, .003, .004}},
                   {64, 48, 50, 51, 31, 23, DistortionModel::kPlumbBob, {.1, -.02, .003, .004, .005}},
                   {64, 48, 50, 51, 31, 23, DistortionModel::kRationalPolynomial, {.1, .2, 0, 0, .1, .2, .3, .1}},
                   {64, 48, 50, 51, 31, 23, DistortionModel::kEquidistant, {.01, .02, 0, 0}}};
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    ColmapImage image;
    image.camera = i;
    image.name = "view " + std::to_string(i) + ".png";
    image.map_from_camera.translation() = Eigen::Vector3d(0.1, 1e6 + 1.0 / 3, -5);
    image.map_from_camera.linear() =
        Eigen::AngleAxisd(static_cast<double>(i), Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    model.images.push_back(image);
  }
  writeColmapModel(scratch / "new", model);
  const auto read = readColmapModel(scratch / "new");
  ASSERT_EQ(read.cameras.size(), model.cameras.size());
  ASSERT_EQ(read.images.size(), model.images.size());
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    auto distortion = model.cameras[i].distortion, read_distortion = read.cameras[i].distortion;
    distortion.resize(8, 0);
    read_distortion.resize(8, 0);
    EXPECT_EQ(read_distortion, distortion);
    EXPECT_EQ(read.cameras[i].fy, model.cameras[i].fy);
    EXPECT_EQ(read.cameras[i].cx, model.cameras[i].cx);
    EXPECT_EQ(read.images[i].name, model.images[i].name);
    EXPECT_EQ(read.images[i].camera, i);
    const Eigen::Isometry3d error = read.images[i].map_from_camera.inverse() * model.images[i].map_from_camera;
    EXPECT_LT(error.translation().norm(), 1e-8);
    EXPECT_LT((error.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  }
}

TEST(Colmap, BadFilesAreReportedWithLineAndReason) {
  ScratchDirectory scratch;
  EXPECT_ERROR(readColmapModel(scratch.path()), "cameras.txt");
  const auto errorOf = [&](const std::string& cameras, const std::string& images) {
    writeModel(scratch, cameras, images);
    return messageOf([&] { readColmapModel(scratch.path()); });
  };
  const auto expectPart = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expectPart(errorOf("#\n1 THIN_PRISM_FISHEYE 6 4 1 1 1 1\n", ""), "cameras.txt line 2: the camera model THIN_PRISM");
  expectPart(errorOf("1 PINHOLE 640 480 500 501 320\n", ""), "has 4 parameters, not 3");
  expectPart(errorOf("1 PINHOLE 640 480 500 501 320 nan\n", ""), "\"nan\" is no number");
  expectPart(errorOf("1 PINHOLE 640 0 500 501 320 240\n", ""), "640 x 0");
  expectPart(errorOf("1 PINHOLE 640 480 0 501 320 240\n", ""), "cameras.txt line 1");
  expectPart(errorOf(std::string(kCamera) + kCamera, ""), "twice");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1\n"), "images.txt line 1: an image is");
  expectPart(errorOf(kCamera, "1 0 0 0 0 0 0 0 1 a.jpg\n"), "norm 0");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 0 0 0 5 b.jpg\n"),
             "images.txt line 3: the camera 5");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1 a.jpg\n\n1 1 0 0 0 0 0 0 1 b.jpg\n"), "the image 1 is there twice");
}

}  // namespace
}  // namespace cloud_colorizer
