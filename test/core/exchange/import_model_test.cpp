// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/import_model.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

/// A cloud of 1000 points about (500, -200, 30), and two photos in folders.
class ImportModel : public ::testing::Test {
 protected:
  ImportModel() {
    cloud_.fields = {{"intensity", FieldType::kFloat32, 1}};
    cloud_.positions = Eigen::Matrix3Xd::Random(3, 1000).colwise() + Eigen::Vector3d(500, -200, 30);
    cloud_.records.assign(4000, 1);
    CloudWriter writer(files_.cloud, 1000, cloud_.fields, true);
    writer.write(cloud_);
    writer.finish();
    model_.cameras.push_back({64, 48, 50, 50, 31.5, 23.5, DistortionModel::kPlumbBob, {}});
    for (const char* name : {"left/a.PNG", "b.jpg"}) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() << 500, -200, 25.0 + static_cast<double>(model_.images.size());
      model_.images.push_back({0, pose, name});
      writeImage(name, 64, 48);
    }
    writeColmapModel(files_.model, model_);
  }

  void writeImage(const std::string& name, int width, int height) {
    const std::filesystem::path path = files_.images + "/" + name;
    std::filesystem::create_directories(path.parent_path());
    cv::imwrite(path.string(), cv::Mat3b(height, width, cv::Vec3b(1, 2, 3)));
  }

  /// White in the upper left corner of the file, with the EXIF orientation 6: to be turned by 90 degrees clockwise.
  /// Returns what the file holds, RGB.
  cv::Mat3b writeTurnedJpeg(const std::string& name, int width, int height) {
    cv::Mat3b image(height, width, cv::Vec3b(0, 0, 0));
    image(cv::Rect(0, 0, 16, 16)).setTo(cv::Vec3b(255, 255, 255));
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", image, bytes);
    const std::vector<std::uint8_t> exif = {0xFF, 0xE1, 0, 34,   'E', 'x', 'i', 'f', 0, 0, 'M', 'M', 0, 42, 0, 0, 0, 8,
                                            0,    1,    1, 0x12, 0,   3,   0,   0,   0, 1, 0,   6,   0, 0,  0, 0, 0, 0};
    bytes.insert(bytes.begin() + 2, exif.begin(), exif.end());
    writeText(files_.images + "/" + name, std::string(bytes.begin(), bytes.end()));
    return image;
  }

  static Callbacks loggingTo(std::string& log) {
    Callbacks callbacks;
    callbacks.log = [&log](LogLevel, const std::string& text) { log += text + '\n'; };
    return callbacks;
  }

  Recording import() {
    RecordParams params;
    params.voxel_size = 0;
    return importModel(files_, scratch_ / "r", params, {});
  }

  std::string log_;
  Callbacks callbacks_ = loggingTo(log_);
  ScratchDirectory scratch_;
  ModelFiles files_{scratch_ / "map.ply", scratch_ / "images", scratch_ / "model", ""};
  ColmapModel model_;
  Cloud cloud_;
};

TEST_F(ImportModel, HasAllPointsViewsAndPoses) {
  const Recording recording = import();
  EXPECT_EQ(recording.numPoints(), 1000U);
  ASSERT_EQ(recording.fields().size(), 1U);
  EXPECT_EQ(recording.fields()[0].name, "intensity");
  ASSERT_EQ(recording.views().size(), 2U);
  for (std::size_t v = 0; v < 2; ++v) {
    const Eigen::Vector3d at = recording.views()[v].map_from_camera.translation() + recording.origin();
    EXPECT_LT((at - model_.images[v].map_from_camera.translation()).norm(), 1e-6);
    EXPECT_EQ(recording.readPixels(v).image.size(), cv::Size(64, 48));
  }
  Eigen::AlignedBox3d box;
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    const Points points = recording.readPoints(tile);
    for (Eigen::Index i = 0; i < points.cols(); ++i) box.extend(points.col(i).cast<double>() + recording.origin());
  }
  EXPECT_LT((box.min() - cloud_.positions.rowwise().minCoeff()).norm(), 1e-3);
  EXPECT_LT((box.max() - cloud_.positions.rowwise().maxCoeff()).norm(), 1e-3);
}

TEST_F(ImportModel, PhotosOfAnotherScaleGetScaledIntrinsics) {
  writeImage("left/a.PNG", 32, 24);
  const Recording recording = import();
  ASSERT_EQ(recording.views().size(), 2U);
  const Intrinsics& scaled = recording.cameras()[recording.views()[0].camera].intrinsics;
  EXPECT_EQ(scaled.width, 32);
  EXPECT_EQ(scaled.fx, 25);
  EXPECT_EQ(scaled.cx, 15.5);  // of pixel centres: (31.5 + 0.5) / 2 - 0.5
  EXPECT_EQ(recording.cameras()[recording.views()[1].camera].intrinsics.width, 64);
}

TEST_F(ImportModel, LabelsOfPhotosBecomeViewsBesideThem) {
  files_.labels = scratch_ / "labels";
  std::filesystem::create_directories(files_.labels + "/left");
  const cv::Mat1b labels(24, 32, std::uint8_t{7});  // smaller than the photo
  cv::imwrite(files_.labels + "/left/a.PNG.png", labels);
  const Recording recording = import();
  ASSERT_EQ(recording.views().size(), 3U);  // one photo has none
  EXPECT_EQ(recording.quantityOf(2).kind, ImageKind::kLabels);
  EXPECT_EQ(recording.views()[2].map_from_camera.matrix(), recording.views()[0].map_from_camera.matrix());
  EXPECT_EQ(recording.readPixels(2).image.at<std::uint8_t>(3, 3), 7);
  EXPECT_EQ(recording.cameras()[recording.views()[2].camera].intrinsics.fx, 25);
  files_.labels = scratch_ / "images";  // of colours
  std::filesystem::remove_all(scratch_ / "r");
  EXPECT_THROW(import(), std::runtime_error);
}

TEST_F(ImportModel, PosesThatCannotBeRightAreTold) {
  RecordParams params;
  params.voxel_size = 0;
  importModel(files_, scratch_ / "right", params, callbacks_);
  EXPECT_EQ(log_, "");
  const std::string images = readText(files_.model + "/images.txt");
  std::string reordered;
  std::istringstream lines(images);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string id, w, rest;
    if (words >> id >> w && id != "#" && std::getline(words, rest)) {
      std::istringstream numbers(rest);
      std::string x, y, z;
      numbers >> x >> y >> z;
      std::getline(numbers, rest);
      line = id + ' ' + x + ' ' + y + ' ' + z + ' ' + w + rest;
    }
    reordered += line + '\n';
  }
  writeText(files_.model + "/images.txt", reordered);
  importModel(files_, scratch_ / "wrong", params, callbacks_);
  EXPECT_NE(log_.find("x y z w"), std::string::npos) << log_;
}

/// The points of the model are some of the cloud's, seen where they appear.
TEST_F(ImportModel, PointsOfTheModelTellWhetherItBelongsToTheCloud) {
  const auto write = [&](double scale, double shift) {
    std::string images, points;
    int id = 1;
    for (std::size_t i = 0; i < model_.images.size(); ++i) {
      images += std::to_string(i + 1) + " 1 0 0 0 ";
      const Eigen::Vector3d place = scale * model_.images[i].map_from_camera.translation();
      for (int axis = 0; axis < 3; ++axis) images += std::to_string(-place[axis]) + ' ';
      images += "1 " + model_.images[i].name + '\n';
      for (Eigen::Index p = 0; p < 60; ++p, ++id) {
        const Eigen::Vector3d point = scale * cloud_.positions.col(p);
        const Eigen::Vector3d local = point - place;
        images += std::to_string(50 * local.x() / local.z() + 32 + shift) + ' ' +
                  std::to_string(50 * local.y() / local.z() + 24) + ' ' + std::to_string(id) + ' ';
        points += std::to_string(id);
        for (int axis = 0; axis < 3; ++axis) points += ' ' + std::to_string(point[axis]);
        points += " 9 9 9 0.5 1 0\n";
      }
      images += '\n';
    }
    writeText(files_.model + "/images.txt", images);
    writeText(files_.model + "/points3D.txt", points);
    std::filesystem::remove_all(scratch_ / "r");
    log_.clear();
    importModel(files_, scratch_ / "r", RecordParams(), callbacks_);
    return log_;
  };
  EXPECT_EQ(write(1, 0).find("3D points"), std::string::npos);
  EXPECT_NE(write(0.9, 0).find("farther than"), std::string::npos);
  EXPECT_NE(write(1, 5).find("% of the image's width beside"), std::string::npos);
  EXPECT_EQ(write(1, 0.3).find("3D points"), std::string::npos);
}

TEST_F(ImportModel, APhotoOfAnotherShapeIsToldBeforeTheWork) {
  writeImage("left/a.PNG", 32, 20);
  files_.cloud = scratch_ / "nowhere.ply";  // not looked at before the photos
  const std::string message = messageOf([&] { import(); });
  for (const char* part : {"left/a.PNG", "32 x 20", "64 x 48", "scaled"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "r"));
  writeImage("left/a.PNG", 48, 64);
  EXPECT_ERROR(import(), "turned");
}

TEST_F(ImportModel, APhotoThatItsExifDataTurnsIsTurnedWhereOnlySoItFits) {
  RecordParams params;
  params.voxel_size = 0;
  const cv::Mat3b lying = writeTurnedJpeg("b.jpg", 64, 48);  // as the model has it: COLMAP does not turn
  const Recording as_it_is = importModel(files_, scratch_ / "lying", params, callbacks_);
  EXPECT_NE(log_.find("b.jpg: has an EXIF orientation, which is not applied"), std::string::npos) << log_;
  EXPECT_LT(cv::norm(as_it_is.readPixels(1).image, lying, cv::NORM_INF), 30);
  log_.clear();
  writeTurnedJpeg("b.jpg", 48, 64);
  const Recording turned = importModel(files_, scratch_ / "turned", params, callbacks_);
  EXPECT_NE(log_.find("b.jpg: turned as its EXIF orientation says"), std::string::npos) << log_;
  const cv::Mat image = turned.readPixels(1).image;
  ASSERT_EQ(image.size(), cv::Size(64, 48));
  EXPECT_GT(image.at<cv::Vec3b>(2, 60)[0], 200);  // the upper left corner is turned to the right
  EXPECT_LT(image.at<cv::Vec3b>(2, 3)[0], 50);
}

TEST_F(ImportModel, WhatIsTransparentIsMasked) {
  cv::Mat4b image(48, 64, cv::Vec4b(9, 8, 7, 255));
  image(10, 20)[3] = 100;
  cv::imwrite(files_.images + "/left/a.PNG", image);
  const Recording recording = import();
  const ViewPixels pixels = recording.readPixels(0);
  EXPECT_EQ(pixels.image.at<cv::Vec3b>(5, 5), cv::Vec3b(7, 8, 9));
  ASSERT_EQ(pixels.mask.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::countNonZero(pixels.mask), 64 * 48 - 1);
  EXPECT_EQ(pixels.mask.at<std::uint8_t>(10, 20), 0);
  EXPECT_TRUE(recording.readPixels(1).mask.empty());
}

TEST_F(ImportModel, MasksAreFoundByTheNamesOfTheirImages) {
  files_.masks = scratch_ / "masks";
  EXPECT_ERROR(import(), "masks");
  std::filesystem::create_directories(files_.masks + "/left");
  EXPECT_ERROR(import(), "has no mask of any image, such as left/a.PNG.png");
  cv::Mat1b mask(24, 32, std::uint8_t{1});  // half the size
  mask(5, 6) = 0;
  cv::imwrite(files_.masks + "/left/a.PNG.png", mask);
  const Recording recording = importModel(files_, scratch_ / "r", {}, callbacks_);
  EXPECT_NE(log_.find("b.jpg: no mask in"), std::string::npos) << log_;
  EXPECT_EQ(cv::countNonZero(recording.readPixels(0).mask), 64 * 48 - 4);
  EXPECT_EQ(recording.readPixels(0).mask.at<std::uint8_t>(11, 13), 0);
  EXPECT_TRUE(recording.readPixels(1).mask.empty());
  cv::imwrite(files_.masks + "/left/a.PNG.png", cv::Mat1b(24, 30));
  EXPECT_ERROR(importModel(files_, scratch_ / "other", {}, {}), "30 x 24");
}

TEST_F(ImportModel, PhotosOfTwelveBitsAreFullScale) {
  cv::imwrite(files_.images + "/left/a.PNG", cv::Mat(48, 64, CV_16UC3, cv::Scalar(1024, 2048, 4095)));
  const cv::Vec3b color = import().readPixels(0).image.at<cv::Vec3b>(3, 3);
  EXPECT_NEAR(color[0], 255, 1);
  EXPECT_NEAR(color[1], 128, 1);
  EXPECT_NEAR(color[2], 64, 1);
}

TEST_F(ImportModel, APanoramaBecomesTheFacesOfACube) {
  writeText(files_.model + "/cameras.txt", "1 EQUIRECTANGULAR 640 320 640 320\n");
  cv::Mat3b panorama(320, 640, cv::Vec3b(10, 20, 30));
  panorama(cv::Rect(480, 120, 80, 80)).setTo(cv::Vec3b(0, 0, 255));  // about 90 degrees to the right
  cv::imwrite(files_.images + "/left/a.PNG", panorama);
  writeText(files_.images + "/b.jpg", "no image");
  files_.masks = scratch_ / "masks";
  std::filesystem::create_directories(files_.masks + "/left");
  cv::Mat1b mask(320, 640, std::uint8_t{255});
  mask(cv::Rect(0, 280, 640, 40)).setTo(0);  // who carries it
  cv::imwrite(files_.masks + "/left/a.PNG.png", mask);
  const Recording recording = importModel(files_, scratch_ / "r", {}, callbacks_);
  EXPECT_NE(log_.find("a view is left out"), std::string::npos) << log_;
  ASSERT_EQ(recording.views().size(), 12U);
  EXPECT_EQ(recording.cameras()[recording.views()[1].camera].name, "camera_0_right");
  const auto middle = [&](std::size_t view) {
    const ViewPixels pixels = recording.readPixels(view);
    const int at = pixels.image.cols / 2;
    const bool is_usable = pixels.mask.empty() || pixels.mask.at<std::uint8_t>(at, at) != 0;
    return is_usable ? pixels.image.at<cv::Vec3b>(at, at) : cv::Vec3b(0, 0, 0);
  };
  EXPECT_EQ(middle(1), cv::Vec3b(255, 0, 0));
  EXPECT_EQ(middle(3), cv::Vec3b(30, 20, 10));
  EXPECT_EQ(middle(5), cv::Vec3b(0, 0, 0));  // below
  EXPECT_EQ(middle(6), cv::Vec3b(0, 0, 0));  // of the damaged one
  const auto names = namesOfViews(readColmapModel(files_.model));
  ASSERT_EQ(names.size(), 12U);
  EXPECT_EQ(names[0], "left/a_front.png");
  writeText(files_.model + "/cameras.txt", "1 EQUIRECTANGULAR 640 480 640 480\n");
  EXPECT_ERROR(readColmapModel(files_.model), "twice as wide as high");
}

TEST_F(ImportModel, APhotoThatIsMissingIsNamed) {
  std::filesystem::remove(files_.images + "/b.jpg");
  EXPECT_ERROR(import(), "b.jpg");
}

TEST_F(ImportModel, APhotoThatIsDamagedIsLeftToTheColouring) {
  writeText(files_.images + "/b.jpg", "no image");
  EXPECT_EQ(import().views().size(), 2U);
}

TEST_F(ImportModel, WhatIsNotThereAndWhatIsAlreadyThereAreRefused) {
  import();
  EXPECT_ERROR(import(), "already holds a recording");
  files_.images = scratch_ / "nowhere";
  EXPECT_ERROR(importModel(files_, scratch_ / "other", {}, {}), "nowhere");
}

TEST_F(ImportModel, ACloudWithoutPointsIsRefused) {
  CloudWriter writer(files_.cloud, 0, {}, true);
  writer.finish();
  EXPECT_ERROR(import(), "no point");
}

}  // namespace
}  // namespace cloud_colorizer
