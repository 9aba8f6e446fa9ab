// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/colmap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

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

TEST(Colmap, FisheyesOfFewerParametersAreEquidistant) {
  ScratchDirectory scratch;
  writeModel(scratch,
             "1 SIMPLE_FISHEYE 64 48 50 32 24\n2 FISHEYE 64 48 50 51 32 24\n"
             "3 SIMPLE_RADIAL_FISHEYE 64 48 50 32 24 .01\n4 RADIAL_FISHEYE 64 48 50 32 24 .01 .002\n"
             "5 THIN_PRISM_FISHEYE 64 48 50 51 32 24 .01 .002 0 0 .003 .004 0 0\n",
             "");
  const auto cameras = readColmapModel(scratch.path()).cameras;
  ASSERT_EQ(cameras.size(), 5U);
  for (const Intrinsics& camera : cameras) EXPECT_EQ(camera.model, DistortionModel::kEquidistant);
  EXPECT_TRUE(cameras[0].distortion.empty());
  EXPECT_EQ(cameras[1].fy, 51);
  EXPECT_EQ(cameras[2].distortion, (std::vector<double>{.01, 0, 0, 0}));
  EXPECT_EQ(cameras[3].distortion, (std::vector<double>{.01, .002, 0, 0}));
  EXPECT_EQ(cameras[4].distortion, (std::vector<double>{.01, .002, .003, .004}));
}

TEST(Colmap, FovIsFollowedToATenthOfAPixel) {
  ScratchDirectory scratch;
  writeModel(scratch, "1 FOV 640 480 400 400 320 240 .9\n", "");
  const Camera camera(readColmapModel(scratch.path()).cameras.at(0));
  for (const double r : {0.01, 0.2, 0.5, 0.9, 1.2}) {
    const auto pixel = camera.projectUnbounded(Eigen::Vector3d(0.8 * r, 0.6 * r, 1).cast<float>());
    ASSERT_TRUE(pixel) << r;
    const double distorted = 400 * std::atan(2 * r * std::tan(0.45)) / 0.9;
    EXPECT_NEAR(pixel->x(), 0.8 * distorted + 319.5, 0.1) << r;
    EXPECT_NEAR(pixel->y(), 0.6 * distorted + 239.5, 0.1) << r;
  }
}

TEST(Colmap, AByteOrderMarkIsPassedOver) {
  ScratchDirectory scratch;
  writeText(scratch / "cameras.txt", "\xEF\xBB\xBF# cameras\n1 PINHOLE 64 48 50 50 32 24\n");
  writeText(scratch / "images.txt",
            "\xEF\xBB\xBF"
            "1 1 0 0 0 0 0 0 1 a.png\n");
  EXPECT_EQ(readColmapModel(scratch.path()).images.size(), 1U);
}

TEST(Colmap, LinesOfPointsMayBeMissing) {
  ScratchDirectory scratch;
  const std::string image = " 1 0 0 0 0 0 0 1 a.jpg\n";
  for (const char* points : {"", "\n", "1 2 3 4 5 6\n", "\n\n"}) {
    std::string images = "# images\n";
    for (int i = 1; i <= 4; ++i) images += std::to_string(i) + image + points;
    writeModel(scratch, kCamera, images);
    EXPECT_EQ(readColmapModel(scratch.path()).images.size(), 4U) << points;
  }
}

TEST(Colmap, PosesOfFramesCount) {
  ScratchDirectory scratch;
  writeModel(scratch, std::string(kCamera) + "2 PINHOLE 640 480 500 501 320 240\n",
             "1 1 0 0 0 9 9 9 1 a.jpg\n\n2 1 0 0 0 9 9 9 2 b.jpg\n\n");
  writeText(scratch / "rigs.txt", "# rigs\n4 2 CAMERA 1 CAMERA 2 1 1 0 0 0 -0.5 0 0\n");
  writeText(scratch / "frames.txt", "1 4 1 0 0 0 0 0 -3 2 CAMERA 1 1 CAMERA 2 2\n");
  const auto images = readColmapModel(scratch.path()).images;
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].map_from_camera.translation(), Eigen::Vector3d(0, 0, 3));
  EXPECT_EQ(images[1].map_from_camera.translation(), Eigen::Vector3d(0.5, 0, 3));
  writeText(scratch / "frames.txt", "1 5 1 0 0 0 0 0 -3 2 CAMERA 1 1 CAMERA 2 2\n");
  EXPECT_ERROR(readColmapModel(scratch.path()), "frames.txt line 1: the rig 5");
}

TEST(Colmap, TheOnlyModelBelowIsFound) {
  ScratchDirectory scratch;
  std::filesystem::create_directories(scratch / "sparse/0");
  writeText(scratch / "sparse/0/cameras.txt", kCamera);
  writeText(scratch / "sparse/0/images.txt", "");
  EXPECT_EQ(readColmapModel(scratch.path()).directory, scratch / "sparse/0");
  EXPECT_EQ(readColmapModel(scratch / "sparse").directory, scratch / "sparse/0");
  std::filesystem::copy(scratch / "sparse/0", scratch / "sparse/1");
  EXPECT_ERROR(readColmapModel(scratch.path()), "name one of them");
}

class BinaryFile {
 public:
  template <class T>
  BinaryFile& add(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  BinaryFile& addName(const std::string& name) {
    bytes_.append(name.c_str(), name.size() + 1);
    return *this;
  }
  BinaryFile& addNumbers(const std::vector<double>& numbers) {
    for (const double number : numbers) add(number);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

TEST(Colmap, BinaryModels) {
  ScratchDirectory scratch;
  using U32 = std::uint32_t;
  using U64 = std::uint64_t;
  BinaryFile cameras, images, rigs, frames;
  cameras.add(U64{1}).add(U32{7}).add(std::int32_t{1}).add(U64{640}).add(U64{480}).addNumbers({500, 501, 320, 240});
  images.add(U64{2});
  for (const U32 id : {2U, 1U}) {
    images.add(id).addNumbers({1, 0, 0, 0, 0, 0, -1.0 * id}).add(U32{7}).addName("v" + std::to_string(id) + ".jpg");
    images.add(U64{1}).addNumbers({1.5, 2.5}).add(std::int64_t{-1});
  }
  writeText(scratch / "cameras.bin", cameras.bytes());
  writeText(scratch / "images.bin", images.bytes());
  ColmapModel model = readColmapModel(scratch.path());
  ASSERT_EQ(model.images.size(), 2U);
  EXPECT_EQ(model.cameras.at(0).cx, 319.5);
  EXPECT_EQ(model.images[0].name, "v1.jpg");
  EXPECT_EQ(model.images[1].map_from_camera.translation().z(), 2);

  rigs.add(U64{1}).add(U32{3}).add(U32{1}).add(std::int32_t{0}).add(U32{7});
  frames.add(U64{1}).add(U32{1}).add(U32{3}).addNumbers({1, 0, 0, 0, 0, 0, -5});
  frames.add(U32{1}).add(std::int32_t{0}).add(U32{7}).add(U64{2});
  writeText(scratch / "rigs.bin", rigs.bytes());
  writeText(scratch / "frames.bin", frames.bytes());
  model = readColmapModel(scratch.path());
  EXPECT_EQ(model.images[0].map_from_camera.translation().z(), 1);
  EXPECT_EQ(model.images[1].map_from_camera.translation().z(), 5);

  for (std::size_t size = 0; size < images.bytes().size(); ++size) {
    writeText(scratch / "images.bin", images.bytes().substr(0, size));
    EXPECT_ERROR(readColmapModel(scratch.path()), "truncated");
  }
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
  EXPECT_ERROR(readColmapModel(scratch.path()), "no COLMAP model");
  const auto errorOf = [&](const std::string& cameras, const std::string& images) {
    writeModel(scratch, cameras, images);
    return messageOf([&] { readColmapModel(scratch.path()); });
  };
  const auto expectPart = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expectPart(errorOf("#\n1 PANORAMA 6 4 1 1 1 1\n", ""), "cameras.txt line 2: the camera model PANORAMA");
  expectPart(errorOf("1 THIN_PRISM_FISHEYE 6 4 1 1 1 1 0 0 .1 0 0 0 0 0\n", ""), "image_undistorter");
  expectPart(errorOf("1 FOV 6 4 1 1 1 1 4\n", ""), "between 0 and pi");
  expectPart(errorOf("1 PINHOLE 640 480 500 501 320\n", ""), "has 4 parameters, not 3");
  expectPart(errorOf("1 PINHOLE 640 480 500 501 320 nan\n", ""), "\"nan\" is no number");
  expectPart(errorOf("1 PINHOLE 640 0 500 501 320 240\n", ""), "640 x 0");
  expectPart(errorOf("1 PINHOLE 640 480 0 501 320 240\n", ""), "cameras.txt line 1");
  expectPart(errorOf(std::string(kCamera) + kCamera, ""), "twice");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1\n"), "images.txt line 1: the line ends too early");
  expectPart(errorOf(kCamera, "1 0 0 0 0 0 0 0 1 a.jpg\n"), "norm 0");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 0 0 0 5 b.jpg\n"),
             "images.txt line 3: the camera 5");
  expectPart(errorOf(kCamera, "1 1 0 0 0 0 0 0 1 a.jpg\n\n1 1 0 0 0 0 0 0 1 b.jpg\n"), "the image 1 is there twice");
}

}  // namespace
}  // namespace cloud_colorizer
