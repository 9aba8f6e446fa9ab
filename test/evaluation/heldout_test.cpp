// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/heldout.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "evaluation/clouds.hpp"
#include "evaluation/refine_pose.hpp"
#include "evaluation/test_bed.hpp"

namespace cloud_colorizer {
namespace {

std::string freshDirectory(const std::string& name) {
  const std::string path = ::testing::TempDir() + name;
  std::filesystem::remove_all(path);
  return path;
}

/// A clean test bed with a smooth texture as a recording: 12 views of one camera.
Recording recordBed(const std::string& directory) {
  TestBedParams params;
  params.num_points = 4000;
  params.num_views = 12;
  params.width = 160;
  params.height = 120;
  params.focal_length = 190;
  params.texture_frequency = 0.2;
  const TestBed bed = renderTestBed(bumpySphere(40), params);
  RecordParams record;
  record.voxel_size = 0;
  record.min_range = 0;
  Recorder recorder(directory, "map", record);
  const std::uint32_t camera = recorder.setCamera("camera_0", bed.intrinsics);
  Cloud cloud;
  cloud.positions = bed.points.cast<double>();
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  for (std::size_t v = 0; v < bed.images.size(); ++v) {
    cv::Mat bgr;
    cv::cvtColor(bed.images[v], bgr, cv::COLOR_RGB2BGR);
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", bgr, bytes);
    recorder.addView(camera, static_cast<double>(v), bed.poses[v], bytes, "png");
  }
  return recorder.snapshot();
}

HeldoutParams simpleMethods() {
  HeldoutParams params;
  params.every = 4;
  params.methods = {Method::kClosest, Method::kMedian, Method::kMean};
  return params;
}

TEST(Heldout, EveryNthViewOfEachCameraIsLeftOut) {
  std::vector<View> views(10);
  for (std::size_t v = 0; v < 10; ++v) views[v].camera = v % 2;
  EXPECT_EQ(heldoutViews(views, 4), (std::vector<std::size_t>{4, 5}));
  EXPECT_TRUE(heldoutViews({views[0]}, 8).empty());
  EXPECT_THROW(heldoutViews(views, 1), std::invalid_argument);
}

TEST(Heldout, TrainingRecordingHasTheOtherViewsAndAllPoints) {
  const Recording recording = recordBed(freshDirectory("heldout_source"));
  const Recording training = withViews(recording, {0, 3, 7}, freshDirectory("heldout_training"));
  ASSERT_EQ(training.views().size(), 3U);
  EXPECT_TRUE(training.views()[1].map_from_camera.isApprox(recording.views()[3].map_from_camera));
  EXPECT_EQ(training.numPoints(), recording.numPoints());
  EXPECT_EQ(training.readPixels(2).image.size(), recording.readPixels(7).image.size());
}

TEST(Heldout, CleanScenePredictsTheImagesThatWereLeftOut) {
  const Recording recording = recordBed(freshDirectory("heldout_clean"));
  const std::string output = freshDirectory("heldout_output");
  const HeldoutResult result = scoreHeldout(recording, simpleMethods(), output, Callbacks{});
  ASSERT_EQ(result.methods.rows.size(), 3U);
  EXPECT_EQ(result.views.rows.size(), 9U);  // three views, three methods
  for (const auto& row : result.methods.rows) {
    EXPECT_LT(std::stod(row[result.methods.column("median")]), 3) << row[0];
    EXPECT_GT(std::stod(row[result.methods.column("coverage")]), 0.8) << row[0];
    EXPECT_LT(std::stod(row[result.methods.column("moved_percent")]), 2) << row[0];
  }
  EXPECT_FALSE(cv::imread(output + "/view_2.png").empty());
}

TEST(Heldout, NothingLeftOutIsAnError) {
  const Recording recording = recordBed(freshDirectory("heldout_none"));
  HeldoutParams params = simpleMethods();
  params.every = 100;
  try {
    scoreHeldout(recording, params, freshDirectory("heldout_none_output"), Callbacks{});
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("12 views"), std::string::npos) << error.what();
  }
}

TEST(RefinePose, FindsThePoseOfAnImageOfTheMap) {
  TestBedParams params;
  params.num_points = 20000;
  params.num_views = 1;
  params.width = 320;
  params.height = 240;
  params.focal_length = 375;
  params.texture_frequency = 0.5;
  TestBed bed = renderTestBed(bumpySphere(60), params);
  const TestBed noisy = addNoise(bed, NoiseParams{0.15, 0.002, 0.1, 2}, 4);
  const Eigen::Vector3f towards = bed.true_poses[0].translation().normalized().cast<float>();
  std::vector<Eigen::Index> facing;
  for (Eigen::Index p = 0; p < bed.points.cols(); ++p) {
    if (bed.points.col(p).normalized().dot(towards) > 0.85F) facing.push_back(p);
  }
  Points points(3, facing.size());
  Values colors(3, facing.size());
  for (std::size_t k = 0; k < facing.size(); ++k) {
    points.col(static_cast<Eigen::Index>(k)) = bed.points.col(facing[k]);
    colors.col(static_cast<Eigen::Index>(k)) = bed.truth.col(facing[k]);
  }
  const Camera camera(bed.intrinsics);
  const Eigen::Isometry3d found = refinePose(points, colors, camera, noisy.images[0], noisy.poses[0]);
  bed.points = points;  // the error of those that the image shows
  EXPECT_GT(meanReprojectionError(bed, noisy.poses), 0.7);
  EXPECT_LT(meanReprojectionError(bed, {found}), 0.15);
  EXPECT_TRUE(
      refinePose(Points(3, 0), Values(3, 0), camera, noisy.images[0], noisy.poses[0]).isApprox(noisy.poses[0], 0));
}

TEST(ColoredCloud, ColoursFromPackedOrSeparateFields) {
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xd::Zero(3, 1);
  cloud.fields = {{"rgb", FieldType::kFloat32}, {"view_count", FieldType::kUint16}};
  const std::uint32_t packed = 10U << 16U | 20U << 8U | 30U;
  const std::uint16_t count = 7;
  cloud.records.resize(6);
  std::memcpy(cloud.records.data(), &packed, 4);
  std::memcpy(cloud.records.data() + 4, &count, 2);
  const ColoredCloud a = coloredCloud(cloud, "a");
  EXPECT_EQ(a.colors.col(0), Eigen::Vector3f(10, 20, 30));
  EXPECT_EQ(a.count[0], 7);
  cloud.fields = {{"blue", FieldType::kUint8}, {"red", FieldType::kUint8}, {"green", FieldType::kUint8}};
  cloud.records = {1, 2, 3};
  EXPECT_EQ(coloredCloud(cloud, "b").colors.col(0), Eigen::Vector3f(2, 3, 1));
}

TEST(ColoredCloud, WithoutColoursIsRefused) {
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xd::Zero(3, 1);
  cloud.fields = {{"intensity", FieldType::kFloat32}};
  cloud.records.resize(4);
  try {
    coloredCloud(cloud, "truth.ply");
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("truth.ply: the cloud has no colours"), std::string::npos);
  }
}

}  // namespace
}  // namespace cloud_colorizer
