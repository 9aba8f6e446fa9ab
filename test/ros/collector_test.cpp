// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/collector.hpp"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/ros/conversions.hpp"
#include "core/scratch.hpp"
#include "ros/messages.hpp"

namespace cloud_colorizer {
namespace {

using testing_ros::encoded;
using testing_ros::imageMessage;
using testing_ros::infoMessage;
using testing_ros::PointWriter;
using testing_ros::transformMessage;

/// A vehicle that drives along x with 1 m/s; frames map -> base (moving) -> lidar, camera (fixed).
class CollectorTest : public testing::Test {
 protected:
  CollectorTest() {
    params_.tf_wait = 1;
    params_.record.voxel_size = 0;
    params_.record.min_range = 0;
    params_.record.keyframe_distance = 0.5;
  }
  ~CollectorTest() override {
    collector_.reset();
    recorder_.reset();
  }

  Collector& collector() {
    if (!collector_) {
      recorder_ = std::make_unique<Recorder>(scratch_ / "recording", "map", params_.record);
      CollectorEvents events;
      events.log = [this](LogLevel, const std::string& text) { log_.push_back(text); };
      collector_ = std::make_unique<Collector>(*recorder_, params_, events);
      tf2_msgs::TFMessage fixed = transformMessage("base", "lidar", 0, 0, 0, 2);
      fixed.transforms.push_back(transformMessage("base", "camera", 0, 0, 1, 0).transforms[0]);
      collector_->addTransforms(fixed, true);
    }
    return *collector_;
  }

  void drive(double from, double to) {
    for (double t = from; t <= to + 1e-9; t += 0.1)
      collector().addTransforms(transformMessage("map", "base", t, t), false);
  }

  void addCloud(double stamp, const std::string& frame = "lidar") {
    auto cloud = PointWriter().field("x", 7).field("y", 7).field("z", 7).done(1, 1);
    const float position[3] = {1, 2, 3};
    std::memcpy(cloud.data.data(), position, 12);
    cloud.header.stamp.fromSec(stamp);
    cloud.header.frame_id = frame;
    collector().addCloud(boost::make_shared<sensor_msgs::PointCloud2>(cloud));
    collector().process();
  }

  void addInfo(std::size_t camera = 0, std::uint32_t width = 8) {
    collector().addCameraInfo(camera, boost::make_shared<sensor_msgs::CameraInfo>(infoMessage(width, 6)));
  }

  void addImage(double stamp, sensor_msgs::Image image = imageMessage("mono8", 8, 6, {1, 2}), std::size_t camera = 0) {
    image.header.stamp.fromSec(stamp);
    image.header.frame_id = "/camera";  // old drivers write a slash
    collector().addImage(camera, boost::make_shared<sensor_msgs::Image>(image));
    collector().process();
  }

  void addCompressed(double stamp, sensor_msgs::CompressedImage image) {
    image.header.stamp.fromSec(stamp);
    image.header.frame_id = "camera";
    collector().addImage(0, boost::make_shared<sensor_msgs::CompressedImage>(image));
    collector().process();
  }

  /// 4 x 3, columns of these values in turn.
  void addMask(double stamp, const std::vector<std::uint8_t>& values) {
    auto mask = imageMessage("mono8", 4, 3, values);
    mask.header.stamp.fromSec(stamp);
    collector().addMask(0, boost::make_shared<sensor_msgs::Image>(mask));
    collector().process();
  }

  static sensor_msgs::Image rgba(const std::vector<std::uint8_t>& pixels) {
    sensor_msgs::Image image = imageMessage("mono8", 8, 6, {1});
    image.encoding = "rgba8";
    image.step = 32;
    image.data = pixels;
    return image;
  }

  Recording finished() {
    collector().finish();
    return recorder_->snapshot();
  }

  std::size_t cloudCount(Outcome outcome) { return collector().stats().cloud.count(outcome); }
  std::size_t imageCount(Outcome outcome) { return collector().stats().cameras[0].count(outcome); }
  bool logged(const std::string& text) const {
    for (const std::string& line : log_) {
      if (line.find(text) != std::string::npos) return true;
    }
    return false;
  }

  ScratchDirectory scratch_;
  CollectorParams params_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Collector> collector_;
  std::vector<std::string> log_;
};

TEST_F(CollectorTest, WhatShowsNoColoursIsKeptNumberByNumber) {
  params_.cameras.resize(3);
  params_.cameras[0].kind = params_.cameras[1].kind = ImageKind::kRadiometric;
  params_.cameras[2].kind = ImageKind::kLabels;
  params_.cameras[0].scale = 0.5;
  drive(10, 14);
  for (std::size_t camera = 0; camera < 3; ++camera) addInfo(camera);
  sensor_msgs::Image counts = imageMessage("16UC1", 8, 6, {0});
  counts.step = 16;
  counts.data.assign(96, 1);
  addImage(10.5, counts, 0);
  sensor_msgs::Image degrees = counts;
  degrees.encoding = "32FC1";
  degrees.step = 32;
  degrees.data.assign(192, 0);
  const float value = 36.6F;
  std::memcpy(degrees.data.data(), &value, 4);
  addImage(10.5, degrees, 1);
  addImage(10.5, imageMessage("mono8", 8, 6, {5, 9}), 2);
  addImage(11.5, imageMessage("rgb8", 8, 6, {5, 9}), 2);
  collector().finish();
  const Recording recording = recorder_->snapshot();
  ASSERT_EQ(recording.views().size(), 3U);
  EXPECT_EQ(recording.quantities().size(), 2U);
  for (std::size_t v = 0; v < 3; ++v) {
    const cv::Mat image = recording.readPixels(v).image;
    if (image.type() == CV_16UC1) {
      EXPECT_EQ(image.at<std::uint16_t>(3, 3), 257);  // not stretched to 16 bits
    } else if (image.type() == CV_32FC1) {
      EXPECT_EQ(image.at<float>(0, 0), value);
    } else {
      EXPECT_EQ(image.at<std::uint8_t>(0, 1), 9);
    }
    EXPECT_EQ(image.channels(), 1);
  }
  EXPECT_EQ(collector().stats().cameras[2].count(Outcome::kUndecodable), 1U);
  EXPECT_NE(collector().stats().cameras[2].last_error.find("rgb8"), std::string::npos);
}

TEST_F(CollectorTest, NothingReceivedGivesAnEmptyRecording) {
  const Recording recording = finished();
  EXPECT_EQ(recording.numPoints(), 0U);
  EXPECT_TRUE(recording.views().empty());
}

TEST_F(CollectorTest, CloudIsPlacedByTheTransformAtItsExactStamp) {
  drive(10, 11);
  addCloud(10.35);
  const Recording recording = finished();
  ASSERT_EQ(recording.numPoints(), 1U);
  const Eigen::Vector3f expected(11.35F, 2, 5);
  EXPECT_LT((recording.readPoints(0).col(0) - expected).norm(), 1e-4F);
}

/// Today's seconds in a double are 0.2 us coarse; rounded up, they would lie behind the last transform.
TEST_F(CollectorTest, StampsOfTodayAreExact) {
  addInfo();
  for (int i = 0; i < 50; ++i) {
    auto transform = transformMessage("map", "base", 0, i);
    auto image = imageMessage("mono8", 8, 6, {1, 2});
    transform.transforms[0].header.stamp = ros::Time(1763800000 + i, 123456789U + 7U * static_cast<unsigned>(i));
    collector().addTransforms(transform, false);
    image.header.stamp = transform.transforms[0].header.stamp;
    image.header.frame_id = "camera";
    collector().addImage(0, boost::make_shared<sensor_msgs::Image>(image));
    collector().process();
    EXPECT_EQ(imageCount(Outcome::kKept), static_cast<std::size_t>(i + 1));
  }
}

/// tf takes rotations that are a little off the unit length; as they are, they would stretch the cloud.
TEST_F(CollectorTest, RotationsOfATransformAreNormalised) {
  auto transform = transformMessage("map", "base", 10, 0);
  transform.transforms[0].transform.rotation.w = 0.6 * 1.004;
  transform.transforms[0].transform.rotation.z = 0.8 * 1.004;
  collector().addTransforms(transform, false);
  addCloud(10, "base");
  const Recording recording = finished();
  ASSERT_EQ(recording.numPoints(), 1U);
  // (1, 2, 3) turned about z by 2 atan(4/3): cos = -0.28, sin = 0.96.
  const Eigen::Vector3f expected(-0.28F - 2 * 0.96F, 0.96F - 2 * 0.28F, 3);
  EXPECT_LT((recording.readPoints(0).col(0) - expected).norm(), 1e-5F);
}

TEST_F(CollectorTest, LateTransformIsWaitedFor) {
  drive(10, 10.2);
  addCloud(10.35);
  EXPECT_EQ(collector().numPending(), 1U);
  drive(10.3, 10.4);
  collector().process();
  EXPECT_EQ(collector().numPending(), 0U);
  EXPECT_EQ(cloudCount(Outcome::kKept), 1U);
  EXPECT_TRUE(log_.empty());
}

TEST_F(CollectorTest, MissingTransformIsNeverExtrapolated) {
  drive(10, 10.2);
  addCloud(10.35);
  addCloud(11.3);
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 0U);
  addCloud(11.4);  // more than tf_wait after the first
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 1U);
  EXPECT_TRUE(logged("extrapolation"));
  EXPECT_EQ(finished().numPoints(), 0U);
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 3U);
}

TEST_F(CollectorTest, FrameOfAnotherMapIsNamed) {
  drive(10, 12);
  collector().addTransforms(transformMessage("other_map", "other_lidar", 0, 0), true);
  addCloud(10.5, "other_lidar");
  finished();
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 1U);
  EXPECT_TRUE(logged("not part of the same tree"));
  EXPECT_TRUE(logged("map_frame (map)"));
}

TEST_F(CollectorTest, FramesThatThereAreAreNamedWhereTheMapFrameIsNone) {
  params_.map_frame = "world";
  drive(10, 12);
  addCloud(10.5);
  finished();
  EXPECT_TRUE(logged("map_frame is world, but tf has the frames base, camera, lidar, map"));
  EXPECT_NE(collector().stats().whyNoPoints().find("set map_frame"), std::string::npos);
}

TEST_F(CollectorTest, NothingIsInterpolatedAcrossAGapOfTf) {
  drive(10, 11);
  drive(13, 14);
  for (const double stamp : {10.55, 11.0, 12.0, 13.5}) addCloud(stamp);
  finished();
  EXPECT_EQ(cloudCount(Outcome::kKept), 3U);
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 1U);
  EXPECT_TRUE(logged("tf of base has a gap of 2 s"));
}

TEST_F(CollectorTest, AFrameThatStandsStillMayHaveGaps) {
  for (const double stamp : {10.0, 11.0, 12.0}) {
    collector().addTransforms(transformMessage("map", "base", stamp, 1 + 0.01 * stamp), false);
  }
  addCloud(10.5);
  addCloud(11.5);
  finished();
  EXPECT_EQ(cloudCount(Outcome::kKept), 2U);
}

TEST_F(CollectorTest, AGapMayBeAllowed) {
  params_.tf_max_gap = 0;
  drive(10, 11);
  drive(13, 14);
  addCloud(12);
  finished();
  EXPECT_EQ(cloudCount(Outcome::kKept), 1U);
}

TEST_F(CollectorTest, TransformsThatContradictEachOtherAreTold) {
  drive(10, 12);
  collector().addTransforms(transformMessage("base", "lidar", 0, 0, 0, 2), true);
  EXPECT_TRUE(log_.empty());
  collector().addTransforms(transformMessage("base", "lidar", 0, 0, 0, 2.5), true);
  EXPECT_TRUE(logged("two static transforms from base to lidar contradict each other by 0.5 m"));
  collector().addTransforms(transformMessage("odom", "base", 12.05, 0), false);
  EXPECT_TRUE(logged("frame base has two parents, map and odom"));
}

TEST_F(CollectorTest, AnotherClockIsToldWithTheOffsetThatFits) {
  drive(10, 12);
  for (const double stamp : {47.0, 48.0, 49.0}) addCloud(stamp);
  finished();
  const std::string why = collector().stats().whyNoPoints();
  EXPECT_NE(why.find("cloud_time_offset=-37.000"), std::string::npos) << why;
  EXPECT_NE(why.find("TAI"), std::string::npos) << why;
}

TEST_F(CollectorTest, CloudsHaveATimeOffset) {
  params_.cloud_time_offset = -37;
  drive(10, 12);
  addCloud(47.5);
  finished();
  EXPECT_EQ(cloudCount(Outcome::kKept), 1U);
}

TEST_F(CollectorTest, ThePointsTellWhyNoneWasRecorded) {
  params_.record.max_range = 2;  // the point is 3.7 m away
  drive(10, 12);
  addCloud(10.5);
  finished();
  EXPECT_NE(collector().stats().whyNoPoints().find("max_range"), std::string::npos);
  EXPECT_NE(collector().stats().whyNoViews().find("camera_0: no image came"), std::string::npos);
}

TEST_F(CollectorTest, CloudsOfTheMapFrameAreMeasuredFromTheFrameThatIsCalledLidar) {
  params_.record.max_range = 5;
  drive(10, 12);
  addCloud(10, "map");  // the point (1, 2, 3) of the map is 9.3 m from the lidar at (10, 0, 2)
  EXPECT_EQ(collector().stats().points.too_far, 1U);
  EXPECT_TRUE(logged("the clouds are in the map frame already"));
}

TEST_F(CollectorTest, BeamsWithoutAReturnAreNoPoints) {
  params_.record.max_range = 1000;
  drive(10, 12);
  auto cloud = PointWriter().field("x", 7).field("y", 7).field("z", 7).done(2, 1);
  std::fill(cloud.data.begin(), cloud.data.begin() + 12, std::uint8_t{0});
  cloud.header.stamp.fromSec(10.5);
  cloud.header.frame_id = "lidar";
  collector().addCloud(boost::make_shared<sensor_msgs::PointCloud2>(cloud));
  finished();
  EXPECT_EQ(collector().stats().points.added, 1U);
  EXPECT_EQ(collector().stats().points.not_finite, 1U);
}

TEST_F(CollectorTest, AnImageWithoutFrameHasThatOfItsInfo) {
  drive(10, 12);
  auto info = infoMessage(8, 6);
  info.header.frame_id = "camera";
  collector().addCameraInfo(0, boost::make_shared<sensor_msgs::CameraInfo>(info));
  auto image = imageMessage("mono8", 8, 6, {1, 2});
  image.header.stamp.fromSec(10.5);
  collector().addImage(0, boost::make_shared<sensor_msgs::Image>(image));
  EXPECT_EQ(finished().views().size(), 1U);
}

TEST_F(CollectorTest, TwelveBitsInSixteenAreFullScale) {
  drive(10, 14);
  addInfo();
  const auto wide = [](std::uint16_t value) {
    return imageMessage("mono16", 8, 6,
                        {static_cast<std::uint8_t>(value & 0xFF), static_cast<std::uint8_t>(value >> 8),
                         static_cast<std::uint8_t>(value & 0xFF), static_cast<std::uint8_t>(value >> 8)});
  };
  addImage(10.5, wide(2048));
  addImage(11.5, wide(1024));  // no brighter for being darker
  addImage(12.5, wide(8192));
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 3U);
  EXPECT_NEAR(recording.readPixels(0).image.at<cv::Vec3b>(3, 3)[0], 128, 1);
  EXPECT_NEAR(recording.readPixels(1).image.at<cv::Vec3b>(3, 3)[0], 64, 1);
  EXPECT_NEAR(recording.readPixels(2).image.at<cv::Vec3b>(3, 3)[0], 128, 1);
  EXPECT_TRUE(logged("the first image fills 12"));
  EXPECT_TRUE(logged("camera_0/bits=14"));
}

TEST_F(CollectorTest, CompressedImagesOfSixteenBitsAreScaledAsWell) {
  params_.cameras[0].bits = 10;
  drive(10, 12);
  addInfo();
  auto image = encoded(cv::Mat1w(6, 8, std::uint16_t{512}), "png");
  image.format = "mono16; png compressed ";
  addCompressed(10.5, image);
  EXPECT_NEAR(finished().readPixels(0).image.at<cv::Vec3b>(3, 3)[0], 128, 1);
}

TEST_F(CollectorTest, WhatIsTransparentIsMasked) {
  addInfo();
  drive(10, 13);
  std::vector<std::uint8_t> pixels(8 * 6 * 4, 255);
  addImage(10.5, rgba(pixels));
  pixels[4 * 9 + 3] = 0;
  addImage(11.5, rgba(pixels));
  const Recording recording = finished();
  EXPECT_TRUE(recording.readPixels(0).mask.empty());
  const cv::Mat mask = recording.readPixels(1).mask;
  ASSERT_EQ(mask.size(), cv::Size(8, 6));
  EXPECT_EQ(cv::countNonZero(mask), 47);
  EXPECT_EQ(mask.at<std::uint8_t>(1, 1), 0);
}

TEST_F(CollectorTest, EveryImageWaitsForItsMask) {
  params_.cameras[0].masks = true;
  addInfo();
  drive(10, 16);
  addImage(10.5);
  EXPECT_EQ(imageCount(Outcome::kKept), 0U);
  addMask(10.5, {255, 0});
  EXPECT_EQ(imageCount(Outcome::kKept), 1U);
  addMask(11.5, {0, 0});  // before its image
  addImage(11.5);
  EXPECT_EQ(imageCount(Outcome::kKept), 2U);
  addMask(13.5, {1, 1});
  addImage(12.5);  // its mask did not come
  EXPECT_EQ(imageCount(Outcome::kNoMask), 1U);
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 2U);
  EXPECT_EQ(cv::countNonZero(recording.readPixels(0).mask), 24);  // the mask has half the size
  EXPECT_EQ(cv::countNonZero(recording.readPixels(1).mask), 0);
}

TEST_F(CollectorTest, APanoramaBecomesSixViewsWithoutACameraInfo) {
  params_.cameras[0].model = "equirectangular";
  drive(10, 12);
  addImage(10.5, imageMessage("mono8", 80, 40, {100, 100}));
  addImage(11.5, imageMessage("mono8", 80, 60, {100, 100}));
  EXPECT_EQ(imageCount(Outcome::kKept), 1U);
  EXPECT_EQ(imageCount(Outcome::kSizeMismatch), 1U);
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 6U);
  ASSERT_EQ(recording.cameras().size(), 6U);
  EXPECT_EQ(recording.cameras()[1].name, "camera_0_right");
  const Eigen::Isometry3d front = recording.views()[0].map_from_camera;
  EXPECT_LT((front.translation() - recording.views()[1].map_from_camera.translation()).norm(), 1e-9);
  const Eigen::Vector3d ahead = recording.views()[1].map_from_camera.linear().col(2);
  EXPECT_LT((ahead - front.linear().col(0)).norm(), 1e-9);  // the right face looks along x of the camera
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(recording.readPixels(i).image.at<cv::Vec3b>(9, 9), cv::Vec3b(100, 100, 100));
  }
}

TEST_F(CollectorTest, OfAPanoramaThatWasRecordedInPartTheOtherFacesAreAdded) {
  params_.cameras[0].model = "equirectangular";
  const auto record = [&] {
    drive(10, 12);
    addImage(10.5, imageMessage("mono8", 80, 40, {100, 100}));
    addImage(11.5, imageMessage("mono8", 80, 40, {50, 50}));
    return finished();
  };
  EXPECT_EQ(record().views().size(), 12U);
  collector_.reset();
  recorder_.reset();
  const std::string table = scratch_ / "recording/views.csv";
  std::string lines = readText(table);
  for (int i = 0; i < 2; ++i) lines.erase(lines.rfind('\n', lines.size() - 2) + 1);
  writeText(table, lines);
  const Recording again = record();
  ASSERT_EQ(again.views().size(), 12U);
  EXPECT_EQ(readText(table).substr(0, lines.size()), lines);
  EXPECT_EQ(again.cameras()[again.views()[11].camera].name, "camera_0_down");
}

TEST_F(CollectorTest, APanoramaOfAnotherShapeIsRefusedAgainAndAgain) {
  params_.cameras[0].model = "equirectangular";
  drive(10, 13);
  addImage(10.5, imageMessage("mono8", 80, 40, {100, 100}));
  addImage(11.5, imageMessage("mono8", 80, 60, {100, 100}));
  addImage(12.5, imageMessage("mono8", 80, 60, {100, 100}));
  EXPECT_EQ(imageCount(Outcome::kSizeMismatch), 2U);
  EXPECT_EQ(finished().views().size(), 6U);
}

TEST_F(CollectorTest, AMaskOfAnotherShapeIsRefused) {
  params_.cameras[0].masks = true;
  addInfo();
  drive(10, 11);
  auto mask = imageMessage("mono8", 8, 3, {1, 1});
  mask.header.stamp.fromSec(10.5);
  collector().addMask(0, boost::make_shared<sensor_msgs::Image>(mask));
  addImage(10.5);
  EXPECT_EQ(imageCount(Outcome::kNoMask), 1U);
  EXPECT_NE(collector().stats().cameras[0].last_error.find("8 x 3"), std::string::npos);
}

TEST_F(CollectorTest, TheRightCameraOfAPairStandsBesideTheirCommonFrame) {
  params_.cameras.resize(2);
  params_.cameras[0].rectified = params_.cameras[1].rectified = true;
  drive(10, 12);
  for (std::size_t camera = 0; camera < 2; ++camera) {
    auto info = infoMessage(8, 6);
    info.header.frame_id = "camera";
    if (camera == 1) info.P[3] = -0.5 * info.P[0];
    collector().addCameraInfo(camera, boost::make_shared<sensor_msgs::CameraInfo>(info));
  }
  for (std::size_t camera = 0; camera < 2; ++camera) addImage(10.5, imageMessage("mono8", 8, 6, {1, 2}), camera);
  const auto views = finished().views();
  ASSERT_EQ(views.size(), 2U);
  const Eigen::Vector3d between = views[0].map_from_camera.inverse() * views[1].map_from_camera.translation();
  EXPECT_LT((between - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-9) << between.transpose();
}

TEST_F(CollectorTest, RangesAreMeasuredFromTheSensorFrame) {
  params_.sensor_frame = "lidar";
  params_.record.max_range = 5;
  drive(10, 12);
  addCloud(10, "map");  // the point (1, 2, 3) of the map is 9.3 m from the lidar at (10, 0, 2)
  EXPECT_EQ(collector().stats().points.too_far, 1U);
}

TEST_F(CollectorTest, WarningsDoNotStorm) {
  addCloud(10);
  for (int i = 1; i < 200; ++i) addCloud(10 + 0.1 * i);
  finished();
  EXPECT_EQ(cloudCount(Outcome::kNoTransform), 200U);
  EXPECT_LE(log_.size(), 2U);
}

TEST_F(CollectorTest, StampOfZeroAndEmptyFrameAreRefused) {
  drive(10, 11);
  addCloud(0);
  EXPECT_EQ(cloudCount(Outcome::kNoStamp), 1U);
  addCloud(10.5, "");
  EXPECT_EQ(cloudCount(Outcome::kMalformed), 1U);
  EXPECT_TRUE(logged("frame_id is empty"));
}

/// What is added to such a stamp does not fit into 32 bits, and ros::Time throws.
TEST_F(CollectorTest, StampsOutOfRangeAreDroppedAndCounted) {
  drive(10, 11);
  addInfo();
  addCloud(4294967295.0);
  auto image = imageMessage("mono8", 8, 6, {1, 2});
  addImage(4294967295.0, image);
  for (const std::uint32_t sec : {4294967295U, 4294967290U}) {
    auto transform = transformMessage("map", "base", 0, 0);
    transform.transforms[0].header.stamp = ros::Time(sec, 999999999U);
    collector().addTransforms(transform, false);
  }
  addCloud(10.5);
  addImage(10.5);
  EXPECT_EQ(cloudCount(Outcome::kBadStamp), 1U);
  EXPECT_EQ(imageCount(Outcome::kBadStamp), 1U);
  EXPECT_EQ(collector().stats().bad_transforms, 2U);
  EXPECT_EQ(cloudCount(Outcome::kKept), 1U);
  EXPECT_EQ(imageCount(Outcome::kKept), 1U);
  EXPECT_EQ(collector().stats().time_jumps, 0U);
  EXPECT_TRUE(logged("clouds: the stamp of 4294967295 s is out of range"));
  EXPECT_TRUE(logged("tf of base: the stamp of 4294967295 s is out of range"));
  EXPECT_NE(collector().stats().describe().find("tf: 2 stamp out of range"), std::string::npos);
}

TEST_F(CollectorTest, MalformedCloudIsCountedAndTheNextIsKept) {
  drive(10, 11);
  auto cloud = PointWriter().field("x", 7).field("y", 7).done(1, 1);
  cloud.header.stamp.fromSec(10.1);
  cloud.header.frame_id = "lidar";
  collector().addCloud(boost::make_shared<sensor_msgs::PointCloud2>(cloud));
  addCloud(10.2);
  EXPECT_EQ(cloudCount(Outcome::kMalformed), 1U);
  EXPECT_EQ(cloudCount(Outcome::kKept), 1U);
  EXPECT_TRUE(logged("no field z"));
}

TEST_F(CollectorTest, ViewsAreKeptEveryKeyframeDistance) {
  drive(10, 12);
  addInfo();
  for (int i = 0; i <= 20; ++i) addImage(10 + 0.1 * i);
  const Recording recording = finished();
  EXPECT_EQ(imageCount(Outcome::kKept), recording.views().size());
  EXPECT_EQ(imageCount(Outcome::kKept) + imageCount(Outcome::kNotKeyframe), 21U);
  ASSERT_GE(recording.views().size(), 4U);
  ASSERT_LE(recording.views().size(), 5U);
  EXPECT_LT((recording.views()[0].map_from_camera.translation() - Eigen::Vector3d(10, 1, 0)).norm(), 1e-6);
  EXPECT_EQ(recording.readPixels(1).image.size(), cv::Size(8, 6));
}

TEST_F(CollectorTest, TimeOffsetMovesThePose) {
  params_.cameras[0].time_offset = 0.25;
  drive(10, 11);
  addInfo();
  addImage(10.5);
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 1U);
  EXPECT_NEAR(recording.views()[0].map_from_camera.translation().x(), 10.75, 1e-6);
  EXPECT_NEAR(recording.views()[0].stamp, 10.75, 1e-6);
}

TEST_F(CollectorTest, ARollingShutterHasThePoseOfItsMiddleRowAndItsMotion) {
  params_.cameras[0].readout_time = 0.2;
  drive(10, 11);
  addInfo();
  addImage(10.5);
  addImage(10.9);  // its last row was read after the last pose
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 1U);
  EXPECT_EQ(recording.views()[0].stamp, 10.5);
  EXPECT_NEAR(recording.views()[0].map_from_camera.translation().x(), 10.6, 1e-6);
  EXPECT_NEAR((recording.views()[0].readout_motion - (Twist() << 0, 0, 0, 0.2, 0, 0).finished()).norm(), 0, 1e-6);
  EXPECT_EQ(imageCount(Outcome::kNoTransform), 1U);
}

TEST_F(CollectorTest, TimeOffsetBeforeTheBeginOfTimeIsRefused) {
  params_.cameras[0].time_offset = -1;
  drive(0.1, 1);
  addInfo();
  addImage(0.5);
  EXPECT_EQ(imageCount(Outcome::kNoStamp), 1U);
}

TEST_F(CollectorTest, CompressedBytesAreKeptAsReceived) {
  drive(10, 11);
  addInfo();
  const auto image = encoded(cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)), "jpg");
  addCompressed(10.5, image);
  const Recording recording = finished();
  ASSERT_EQ(recording.views().size(), 1U);
  const std::string file = recording.directory() + "/" + recording.views()[0].image;
  EXPECT_EQ(std::filesystem::file_size(file), image.data.size());
  EXPECT_EQ(file.substr(file.size() - 4), ".jpg");
}

TEST_F(CollectorTest, BadImagesAreRefusedByReason) {
  drive(10, 13);
  addImage(10);
  EXPECT_EQ(collector().numPending(), 1U);  // camera_info may still come
  addInfo(0, 9);
  collector().process();
  EXPECT_EQ(imageCount(Outcome::kSizeMismatch), 1U);
  EXPECT_TRUE(logged("8 x 6"));
  addInfo(0, 8);
  addImage(10.1, imageMessage("jpegxl", 8, 6, {1, 2}));
  auto truncated = encoded(cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)), "jpg");
  truncated.data.resize(truncated.data.size() / 2);
  addCompressed(10.2, truncated);
  EXPECT_EQ(imageCount(Outcome::kUndecodable), 2U);
  addImage(10.3);
  EXPECT_EQ(imageCount(Outcome::kKept), 1U);
}

TEST_F(CollectorTest, ImageWithoutCameraInfoIsGivenUp) {
  drive(10, 13);
  addImage(10);
  finished();
  EXPECT_EQ(imageCount(Outcome::kNoCameraInfo), 1U);
  EXPECT_TRUE(logged("no camera_info"));
}

TEST_F(CollectorTest, UncalibratedCameraIsRefusedWithTheReason) {
  drive(10, 13);
  sensor_msgs::CameraInfo info = infoMessage(8, 6);
  info.K.fill(0);
  collector().addCameraInfo(0, boost::make_shared<sensor_msgs::CameraInfo>(info));
  addImage(10);
  EXPECT_EQ(imageCount(Outcome::kBadCameraInfo), 1U);
  EXPECT_TRUE(logged("uncalibrated"));
}

/// A damaged message of a few bytes may claim any size: nothing of it may be allocated, here or by who reads the view.
TEST_F(CollectorTest, ImagesBeyondTheLargestSizeAreRefused) {
  drive(10, 13);
  sensor_msgs::CameraInfo info = infoMessage(40000, 40000);
  collector().addCameraInfo(0, boost::make_shared<sensor_msgs::CameraInfo>(info));
  auto image = encoded(cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)), "png");
  image.data[18] = image.data[22] = 40000 >> 8;
  image.data[19] = image.data[23] = 40000 & 255;
  ASSERT_EQ(inspectCompressed(image).size, cv::Size(40000, 40000));
  addCompressed(10, image);
  addImage(10.1);
  EXPECT_EQ(imageCount(Outcome::kTooLarge), 2U);
  EXPECT_TRUE(logged("40000 x 40000 px is larger than ~max_image_size = 200 Mpx"));
  EXPECT_TRUE(finished().cameras().empty());  // whoever opens the recording would allocate it
  addInfo();
  addImage(10.2);
  EXPECT_EQ(imageCount(Outcome::kKept), 1U);
}

TEST_F(CollectorTest, MaskOfAnotherSizeIsNotIgnored) {
  params_.cameras[0].mask = scratch_ / "mask.png";
  cv::imwrite(params_.cameras[0].mask, cv::Mat(5, 5, CV_8UC1, cv::Scalar(255)));
  drive(10, 13);
  addInfo();
  addImage(10);
  EXPECT_EQ(imageCount(Outcome::kBadCameraInfo), 1U);
  EXPECT_TRUE(logged("mask"));
}

TEST_F(CollectorTest, MissingMaskIsAnError) {
  params_.cameras[0].mask = scratch_ / "no_such_mask.png";
  EXPECT_THROW(collector(), std::runtime_error);
}

TEST_F(CollectorTest, LoopedBagIsRecordedFurther) {
  addInfo();
  for (int loop = 0; loop < 2; ++loop) {
    for (int i = 0; i <= 50; ++i) {
      const double t = 100 + 0.1 * i;
      collector().addTransforms(transformMessage("map", "base", t, t), false);
      addCloud(t);
    }
  }
  const Recording recording = finished();
  EXPECT_EQ(collector().stats().time_jumps, 1U);
  EXPECT_TRUE(logged("time jumped back"));
  EXPECT_EQ(cloudCount(Outcome::kKept), 102U);
  EXPECT_EQ(recording.numPoints(), 102U);
}

TEST_F(CollectorTest, ContinuedRecordingDoesNotKeepTheSameViewAgain) {
  drive(10, 11);
  addInfo();
  addImage(10);
  finished();
  collector_.reset();
  recorder_.reset();
  drive(10, 11);
  addInfo();
  addImage(10.1);
  EXPECT_EQ(finished().views().size(), 1U);
  EXPECT_EQ(imageCount(Outcome::kNotKeyframe), 1U);
}

TEST_F(CollectorTest, AnotherRecordingBeginsWithItsOwnViewsAndCounters) {
  drive(10, 11);
  addInfo();
  addImage(10);
  finished();
  Recorder other(scratch_ / "other", "map", params_.record);
  collector().useRecorder(other);
  EXPECT_EQ(collector().stats().cameras[0].received, 0U);
  addImage(10.1);
  collector().finish();
  EXPECT_EQ(other.numViews(), 1U);
  collector_.reset();
}

/// The order in which messages of different topics arrive must not change the recording.
TEST_F(CollectorTest, LateTransformsGiveTheSameRecordingAsEarlyOnes) {
  params_.encode_threads = 3;
  addInfo();
  for (int i = 0; i <= 9; ++i) addImage(10 + 0.1 * i);
  for (int i = 0; i <= 9; ++i) addCloud(10 + 0.1 * i);
  drive(10, 11);
  const Recording late = finished();
  collector_.reset();
  recorder_.reset();
  std::filesystem::rename(scratch_ / "recording", scratch_ / "late");
  drive(10, 11);
  addInfo();
  for (int i = 0; i <= 9; ++i) {
    addCloud(10 + 0.1 * i);
    addImage(10 + 0.1 * i);
  }
  const Recording early = finished();
  ASSERT_EQ(early.views().size(), late.views().size());
  for (std::size_t i = 0; i < early.views().size(); ++i) {
    EXPECT_EQ(early.views()[i].stamp, late.views()[i].stamp);
    EXPECT_TRUE(early.views()[i].map_from_camera.isApprox(late.views()[i].map_from_camera));
  }
  EXPECT_EQ(early.numPoints(), late.numPoints());
}

TEST(CollectorParams, OutOfRangeIsRefusedByName) {
  CollectorParams params;
  params.check();
  params.tf_wait = -1;
  EXPECT_THROW(params.check(), std::invalid_argument);
  params = {};
  params.raw_image_format = "tiff";
  EXPECT_THROW(params.check(), std::invalid_argument);
  params = {};
  params.map_frame = "/";
  EXPECT_THROW(params.check(), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
