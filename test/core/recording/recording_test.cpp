// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Bytes = std::vector<std::uint8_t>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A cloud with a field "id" that numbers its points from `first_id`.
Cloud numbered(const std::vector<Vector3d>& positions, std::uint32_t first_id = 0) {
  Cloud cloud;
  cloud.positions.resize(3, static_cast<Eigen::Index>(positions.size()));
  cloud.fields = {{"id", FieldType::kUint32}};
  cloud.records.resize(4 * positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    cloud.positions.col(static_cast<Eigen::Index>(i)) = positions[i];
    const auto id = first_id + static_cast<std::uint32_t>(i);
    std::memcpy(cloud.records.data() + 4 * i, &id, 4);
  }
  return cloud;
}

std::vector<Vector3d> randomPositions(std::size_t count, double half_side, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-half_side, half_side);
  std::vector<Vector3d> positions(count);
  for (auto& position : positions) position = {uniform(random), uniform(random), uniform(random)};
  return positions;
}

RecordParams everything() {
  RecordParams params;
  params.min_range = 0;
  params.max_range = kInf;
  return params;
}

/// id to position of every point of a recording.
std::map<std::uint32_t, Eigen::Vector3f> pointsById(const Recording& recording) {
  std::map<std::uint32_t, Eigen::Vector3f> result;
  for (std::size_t t = 0; t < recording.tiles().size(); ++t) {
    const auto points = recording.readPoints(t);
    const auto records = recording.readRecords(t);
    EXPECT_EQ(static_cast<std::size_t>(points.cols()), recording.tiles()[t].num_points);
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      std::uint32_t id = 0;
      std::memcpy(&id, records.data() + 4 * i, 4);
      EXPECT_TRUE(result.emplace(id, points.col(i)).second);
    }
  }
  return result;
}

Intrinsics smallCamera() {
  return {8, 6, 10, 11, 3.5, 2.5, DistortionModel::kPlumbBob, {0.1, -0.01}};
}

Bytes encoded(const std::string& extension, int type = CV_8UC3, int width = 8, int height = 6) {
  cv::Mat image(height, width, type, cv::Scalar(10, 20, 30));
  if (CV_MAT_DEPTH(type) == CV_16U) image *= 256;
  Bytes bytes;
  cv::imencode("." + extension, image, bytes);
  return bytes;
}

TEST(Recorder, ThinsToTheFirstPointOfEveryVoxel) {
  ScratchDirectory scratch;
  const auto positions = randomPositions(20000, 12, 1);
  auto params = everything();
  params.voxel_size = 0.5;
  params.tile_size = 5;
  Recorder recorder(scratch.path(), "map", params);
  const auto counts = recorder.addCloud(numbered(positions), Isometry3d::Identity());

  std::set<std::array<long, 3>> voxels;
  std::set<std::uint32_t> expected;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto p = positions[i].cast<float>().cast<double>();
    const std::array<long, 3> voxel{std::lround(std::floor(p.x() / 0.5)), std::lround(std::floor(p.y() / 0.5)),
                                    std::lround(std::floor(p.z() / 0.5))};
    if (voxels.insert(voxel).second) expected.insert(static_cast<std::uint32_t>(i));
  }
  const auto recording = recorder.snapshot();
  const auto points = pointsById(recording);
  EXPECT_EQ(counts.added, expected.size());
  EXPECT_EQ(counts.added + counts.voxel_taken, positions.size());
  EXPECT_EQ(recording.numPoints(), expected.size());
  ASSERT_EQ(points.size(), expected.size());
  for (const auto id : expected) EXPECT_EQ(points.at(id), positions[id].cast<float>()) << id;
  for (std::size_t t = 0; t < recording.tiles().size(); ++t) {
    const auto index = recording.tiles()[t].index;
    const auto in_tile = recording.readPoints(t);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(in_tile.row(axis).minCoeff(), 5.0F * static_cast<float>(index[axis]));
      EXPECT_LE(in_tile.row(axis).maxCoeff(), 5.0F * static_cast<float>(index[axis] + 1));
    }
  }
}

TEST(Recorder, FewOpenTilesAndReopeningChangeNothing) {
  ScratchDirectory one, other;
  auto params = everything();
  params.voxel_size = 0.5;
  params.tile_size = 2;
  auto few = params;
  few.max_open_tiles = 3;
  Recorder whole(one.path(), "map", params);
  for (unsigned k = 0; k < 4; ++k) {
    const auto cloud = numbered(randomPositions(3000, 6, k), k * 3000);
    whole.addCloud(cloud, Isometry3d::Identity());
    Recorder again(other.path(), "map", few);
    again.addCloud(cloud, Isometry3d::Identity());
  }
  EXPECT_EQ(pointsById(whole.snapshot()), pointsById(Recording::open(other.path())));
}

TEST(Recorder, VoxelSizeZeroKeepsAll) {
  ScratchDirectory scratch;
  auto params = everything();
  params.voxel_size = 0;
  Recorder recorder(scratch.path(), "map", params);
  EXPECT_EQ(recorder.addCloud(numbered({{1, 1, 1}, {1, 1, 1}}), Isometry3d::Identity()).added, 2U);
  EXPECT_EQ(recorder.snapshot().numPoints(), 2U);
  EXPECT_EQ(recorder.snapshot().tileSize(), 2.5);
}

TEST(Recorder, CountsWhyPointsAreDropped) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(1000, 0, 0);
  const auto counts = recorder.addCloud(
      numbered({{kNaN, 0, 0}, {0, kInf, 0}, {0.5, 0, 0}, {61, 0, 0}, {1e200, 0, 0}, {5, 0, 0}, {5, 0.001, 0.001}}),
      pose);
  EXPECT_EQ(counts.not_finite, 2U);
  EXPECT_EQ(counts.too_near, 1U);
  EXPECT_EQ(counts.too_far, 2U);
  EXPECT_EQ(counts.added, 1U);
  EXPECT_EQ(counts.voxel_taken, 1U);
  EXPECT_EQ(recorder.snapshot().readPoints(0), Eigen::Vector3f(1005, 0, 0));
}

TEST(Recorder, CoordinatesBeyondTheGridAreTooFar) {
  ScratchDirectory scratch;
  auto params = everything();
  params.voxel_size = 0;
  params.tile_size = 0.001;
  Recorder recorder(scratch.path(), "map", params);
  const auto counts = recorder.addCloud(numbered({{1, 0, 0}, {3e6, 0, 0}, {-1e300, 0, 0}}), Isometry3d::Identity());
  EXPECT_EQ(counts.added, 1U);
  EXPECT_EQ(counts.too_far, 2U);
}

TEST(Recorder, EmptyCloudIsHarmless) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  EXPECT_EQ(recorder.addCloud({}, Isometry3d::Identity()).added, 0U);
  const auto recording = recorder.snapshot();
  EXPECT_TRUE(recording.tiles().empty() && recording.views().empty() && recording.fields().empty());
  EXPECT_EQ(Recording::open(scratch.path()).numPoints(), 0U);
}

TEST(Recorder, FarMapGetsItsOwnOriginInWholeKilometres) {
  ScratchDirectory scratch;
  const Vector3d utm(466123.456789, 5429876.54321, 113.25);
  {
    Recorder recorder(scratch.path(), "map", everything());
    recorder.addCloud(numbered({utm, utm + Vector3d(0.1, 0, 0)}), Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", smallCamera());
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = utm;
    recorder.addView(camera, 1, pose, encoded("png"), "png");
  }
  const auto recording = Recording::open(scratch.path());
  EXPECT_EQ(recording.origin(), Vector3d(466000, 5430000, 0));
  EXPECT_LT((recording.readPoints(0).col(0).cast<double>() + recording.origin() - utm).norm(), 1e-4);
  EXPECT_LT((recording.views()[0].map_from_camera.translation() + recording.origin() - utm).norm(), 1e-9);
}

TEST(Recorder, ViewBeforeTheFirstCloudFixesTheOrigin) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everything());
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(123456, 0, 0);
  recorder.addView(recorder.setCamera("camera_0", smallCamera()), 1, pose, encoded("png"), "png");
  recorder.addCloud(numbered({{0, 0, 1}}), pose);
  EXPECT_EQ(recorder.snapshot().origin(), Vector3d(123000, 0, 0));
  EXPECT_EQ(recorder.snapshot().readPoints(0), Eigen::Vector3f(456, 0, 1));
}

TEST(Recorder, LaterCloudsAreFittedToTheFirstFields) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everything());
  recorder.addCloud(numbered({{1, 0, 0}}, 7), Isometry3d::Identity());
  Cloud other;
  other.positions = Vector3d(2, 0, 0);
  other.fields = {{"ring", FieldType::kUint8}};
  other.records = {9};
  const auto counts = recorder.addCloud(other, Isometry3d::Identity());
  EXPECT_EQ(counts.fields_dropped, std::vector<std::string>{"ring"});
  EXPECT_EQ(counts.fields_missing, std::vector<std::string>{"id"});
  EXPECT_EQ(recorder.snapshot().readRecords(0), (Bytes{7, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Recorder, SnapshotStaysWhileTheRecorderAppends) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everything());
  recorder.addCloud(numbered(randomPositions(100, 5, 1)), Isometry3d::Identity());
  const auto snapshot = recorder.snapshot();
  const auto before = pointsById(snapshot);
  recorder.addCloud(numbered(randomPositions(100, 5, 2), 100), Isometry3d::Identity());
  recorder.flush();
  EXPECT_EQ(pointsById(snapshot), before);
  EXPECT_GT(pointsById(Recording::open(scratch.path())).size(), before.size());
}

TEST(Recorder, PosesAreTheSameFromMemoryAndFromTheFiles) {
  ScratchDirectory scratch;
  RecordParams params;
  params.keyframe_distance = 0.001;
  Recorder recorder(scratch / "r", "map", params);
  const auto camera = recorder.setCamera("camera_0", {8, 8, 8, 8, 4, 4, DistortionModel::kPlumbBob, {}});
  for (int i = 0; i < 50; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::Random().normalized()));
    pose.translation() = 100 * Eigen::Vector3d::Random();
    recorder.addView(camera, i, pose, {1}, "png");
    recorder.addScan("lidar", i, 5 * Eigen::Matrix3Xd::Random(3, 20), pose);
  }
  recorder.flush();
  const Recording memory = recorder.snapshot(), files = Recording::open(scratch / "r");
  ASSERT_FALSE(files.scans().empty());
  for (std::size_t i = 0; i < files.views().size(); ++i) {
    EXPECT_EQ(memory.views()[i].map_from_camera.matrix(), files.views()[i].map_from_camera.matrix());
  }
  for (std::size_t i = 0; i < files.scans().size(); ++i) {
    EXPECT_EQ(memory.scans()[i].map_from_sensor.matrix(), files.scans()[i].map_from_sensor.matrix());
  }
}

TEST(Recorder, CamerasAreFoundAgainByNameAndIntrinsics) {
  ScratchDirectory scratch;
  auto other = smallCamera();
  other.fx += 1e-13;
  {
    Recorder recorder(scratch.path(), "map", {});
    EXPECT_EQ(recorder.setCamera("camera_0", smallCamera()), 0U);
    EXPECT_EQ(recorder.setCamera("camera_0", other), 1U);
    auto padded = smallCamera();
    padded.distortion = {0.1, -0.01, 0, 0, 0};
    EXPECT_EQ(recorder.setCamera("camera_0", padded), 0U);
  }
  Recorder recorder(scratch.path(), "map", {});
  EXPECT_EQ(recorder.setCamera("camera_0", other), 1U);
  EXPECT_EQ(recorder.setCamera("camera_0", smallCamera()), 0U);
  EXPECT_EQ(recorder.snapshot().cameras()[1].name, "camera_0_2");
  EXPECT_THROW(recorder.setCamera("../evil", smallCamera()), std::invalid_argument);
  EXPECT_THROW(recorder.setCamera("camera_1", {}), std::invalid_argument);
}

TEST(Recorder, MaskIsKeptAndMustFitTheImages) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  const auto camera = recorder.setCamera("camera_0", smallCamera());
  EXPECT_TRUE(recorder.snapshot().readMask(camera).empty());
  cv::Mat1b mask(6, 8, std::uint8_t{255});
  mask(2, 3) = 0;
  recorder.setMask(camera, mask);
  const auto read = Recording::open(scratch.path()).readMask(camera);
  EXPECT_EQ(cv::norm(read, mask), 0);
  EXPECT_ERROR(recorder.setMask(camera, cv::Mat1b(5, 8)), "8 x 5");
}

TEST(Recorder, AViewMayHaveAMaskOfItsOwn) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  const auto camera = recorder.setCamera("camera_0", smallCamera());
  cv::Mat1b of_camera(6, 8, std::uint8_t{255}), of_view = of_camera.clone();
  of_camera(2, 3) = 0;
  of_view(4, 5) = 0;
  recorder.addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png", of_view);
  recorder.addView(camera, 1, Isometry3d::Identity(), encoded("png"), "png");
  const Recording recording = recorder.snapshot();
  EXPECT_EQ(recording.views()[0].mask, "images/camera_0/000000.mask.png");
  EXPECT_EQ(recording.views()[1].mask, "");
  EXPECT_EQ(cv::norm(recording.readPixels(0).mask, of_view), 0);
  EXPECT_TRUE(recording.readPixels(1).mask.empty());
  recorder.setMask(camera, of_camera);
  const Recording both = recorder.snapshot();
  EXPECT_EQ(cv::countNonZero(both.readPixels(0).mask), 46);
  EXPECT_EQ(cv::norm(both.readPixels(1).mask, of_camera), 0);
  EXPECT_ERROR(recorder.addView(camera, 2, Isometry3d::Identity(), encoded("png"), "png", cv::Mat1b(5, 8)), "8 x 5");
}

TEST(Recorder, ReadoutsBelongToTheirViews) {
  ScratchDirectory scratch;
  const Twist motion = (Twist() << 0.01, 1.0 / 3, 0, -0.2, 0, 1e-7).finished();
  const auto add = [&](const std::vector<Twist>& motions) {
    Recorder recorder(scratch.path(), "map", {});
    const auto camera = recorder.setCamera("camera_0", smallCamera());
    for (const Twist& readout : motions) {
      recorder.addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png", {}, readout);
    }
    return recorder.snapshot().views().back().readout_motion;
  };
  add({Twist::Zero()});
  EXPECT_FALSE(std::filesystem::exists(scratch / "readouts.csv"));
  EXPECT_EQ(add({motion}), motion);
  // A program that was killed left the readout of a view that it could not write.
  std::ofstream(scratch / "readouts.csv", std::ios::app) << "2,1,1,1,1,1,1\n";
  add({Twist::Zero()});
  const Recording recording = Recording::open(scratch.path());
  ASSERT_EQ(recording.views().size(), 3U);
  EXPECT_TRUE(recording.views()[0].readout_motion.isZero(0));
  EXPECT_EQ(recording.views()[1].readout_motion, motion);
  EXPECT_TRUE(recording.views()[2].readout_motion.isZero(0));
  EXPECT_ERROR(add({Twist::Constant(NAN)}), "finite");
}

TEST(Recorder, PosesAndStampsKeepFullPrecision) {
  ScratchDirectory scratch;
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(1.0 / 3, -2e-7, 12.000000001);
  pose.linear() = Eigen::AngleAxisd(0.123456789, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Recorder recorder(scratch.path(), "map", {});
  recorder.addView(recorder.setCamera("camera_0", smallCamera()), 1317046450.123456789, pose, encoded("png"), "png");
  const auto recording = Recording::open(scratch.path());
  ASSERT_EQ(recording.views().size(), 1U);
  const auto& view = recording.views()[0];
  EXPECT_EQ(view.stamp, 1317046450.123456789);
  EXPECT_EQ(view.map_from_camera.translation(), pose.translation());
  EXPECT_LT((view.map_from_camera.linear() - pose.linear()).norm(), 1e-14);
  EXPECT_EQ(view.image, "images/camera_0/000000.png");
}

TEST(Recorder, BadViewsAreRefused) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  const auto camera = recorder.setCamera("camera_0", smallCamera());
  const auto image = encoded("png");
  auto sheared = Isometry3d::Identity();
  sheared.linear()(0, 1) = 0.5;
  auto unknown = Isometry3d::Identity();
  unknown.translation().x() = kNaN;
  EXPECT_THROW(recorder.addView(camera, 0, sheared, image, "png"), std::invalid_argument);
  EXPECT_THROW(recorder.addView(camera, 0, unknown, image, "png"), std::invalid_argument);
  EXPECT_THROW(recorder.addCloud({}, unknown), std::invalid_argument);
  EXPECT_THROW(recorder.addView(camera, kNaN, Isometry3d::Identity(), image, "png"), std::invalid_argument);
  EXPECT_THROW(recorder.addView(camera + 1, 0, Isometry3d::Identity(), image, "png"), std::invalid_argument);
  EXPECT_THROW(recorder.addView(camera, 0, Isometry3d::Identity(), {}, "png"), std::invalid_argument);
  EXPECT_THROW(recorder.addView(camera, 0, Isometry3d::Identity(), image, "../x"), std::invalid_argument);
  EXPECT_EQ(recorder.numViews(), 0U);
}

TEST(RecordParams, BadValuesAreRefusedWithARemedy) {
  const auto check = [](auto change) {
    RecordParams params;
    change(params);
    return messageOf([&] { params.check(); });
  };
  EXPECT_EQ(check([](RecordParams&) {}), "");
  EXPECT_NE(check([](RecordParams& p) { p.voxel_size = -1; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.voxel_size = kNaN; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.voxel_size = 1e-9; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.max_range = 0.5; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.max_open_tiles = 0; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.tile_size = 1000; }), "");
  EXPECT_NE(check([](RecordParams& p) { p.tile_size = 10.02; }).find("for example 10"), std::string::npos);
}

TEST(Recording, ImagesOfAllDepthsBecomeRgb) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  const auto camera = recorder.setCamera("camera_0", smallCamera());
  recorder.addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png");
  recorder.addView(camera, 1, Isometry3d::Identity(), encoded("png", CV_16UC3), "png");
  recorder.addView(camera, 2, Isometry3d::Identity(), encoded("pgm", CV_8UC1), "pgm");
  const auto recording = recorder.snapshot();
  EXPECT_EQ(recording.readPixels(0).image.at<cv::Vec3b>(3, 4), cv::Vec3b(30, 20, 10));
  EXPECT_EQ(recording.readPixels(1).image.at<cv::Vec3b>(3, 4), cv::Vec3b(30, 20, 10));
  EXPECT_EQ(recording.readPixels(2).image.at<cv::Vec3b>(3, 4), cv::Vec3b(10, 10, 10));
}

TEST(Recording, DamagedImagesAreNamed) {
  ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", {});
  auto intrinsics = smallCamera();
  intrinsics.width = intrinsics.height = 64;
  const auto camera = recorder.setCamera("camera_0", intrinsics);
  for (const std::string extension : {"jpg", "png", "ppm"}) {
    auto bytes = encoded(extension, CV_8UC3, 64, 64);
    recorder.addView(camera, 0, Isometry3d::Identity(), bytes, extension);
    bytes.resize(bytes.size() - 10);
    const auto torn = recorder.addView(camera, 0, Isometry3d::Identity(), bytes, extension);
    const auto recording = recorder.snapshot();
    EXPECT_NO_THROW(recording.readPixels(torn - 1)) << extension;
    EXPECT_ERROR(recording.readPixels(torn), recording.views()[torn].image);
  }
  const auto wrong_size = recorder.addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png");
  EXPECT_ERROR(recorder.snapshot().readPixels(wrong_size), "8 x 6");
  std::filesystem::remove_all(scratch / "images");
  EXPECT_ERROR(recorder.snapshot().readPixels(0), "No such file");
}

TEST(Recording, WhatIsNoRecordingIsRefused) {
  ScratchDirectory scratch;
  EXPECT_ERROR(Recording::open(scratch / "missing"), "is not a recording");
  writeText(scratch / "holiday.txt", "sun");
  EXPECT_ERROR(Recorder(scratch.path(), "map", {}), "holiday.txt");
  EXPECT_ERROR(Recorder("/proc/none/rec", "map", {}), "/proc/none/rec");
}

TEST(Recording, AnotherVersionOrSetupIsRefusedWithTheRemedy) {
  ScratchDirectory scratch;
  { Recorder recorder(scratch.path(), "map", {}); }
  RecordParams params;
  params.voxel_size = 0.1;
  EXPECT_ERROR(Recorder(scratch.path(), "map", params), "voxel_size = 0.05");
  EXPECT_ERROR(Recorder(scratch.path(), "odom", {}), "its map frame is \"map\"");
  auto text = readText(scratch / "recording.yaml");
  text.replace(text.find("format_version: 1"), 17, "format_version: 2");
  writeText(scratch / "recording.yaml", text);
  EXPECT_ERROR(Recording::open(scratch.path()), "format version 2");
  EXPECT_ERROR(Recorder(scratch.path(), "map", {}), "format version 2");
  writeText(scratch / "recording.yaml", "format_version: 1\nmap_frame: [");
  EXPECT_ERROR(Recording::open(scratch.path()), "recording.yaml is damaged");
}

TEST(Recording, TwoRecordersOnOneDirectoryAreRefused) {
  ScratchDirectory scratch;
  {
    Recorder recorder(scratch.path(), "map", {});
    EXPECT_ERROR(Recorder(scratch.path(), "map", {}), "another program is recording");
  }
  EXPECT_NO_THROW(Recorder(scratch.path(), "map", {}));
}

TEST(Recording, TornTailsAreIgnoredAndCutWhenContinued) {
  ScratchDirectory scratch;
  std::uint32_t camera = 0;
  {
    Recorder recorder(scratch.path(), "map", everything());
    recorder.addCloud(numbered({{1, 1, 1}, {2, 2, 2}}), Isometry3d::Identity());
    camera = recorder.setCamera("camera_0", smallCamera());
    recorder.addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png");
  }
  const auto tile = scratch / "tiles/0_0_0.pcd";
  const auto whole = readText(tile);
  writeText(tile, whole + "seven bytes and more than a record");
  writeText(scratch / "tiles/5_5_5.pcd", whole.substr(0, 40));
  writeText(scratch / "views.csv", readText(scratch / "views.csv") + "0,1.5,0,0");
  EXPECT_EQ(Recording::open(scratch.path()).numPoints(), 2U);
  EXPECT_EQ(Recording::open(scratch.path()).views().size(), 1U);
  {
    Recorder recorder(scratch.path(), "map", everything());
    recorder.addCloud(numbered({{3, 3, 3}, {52, 52, 52}}, 2), Isometry3d::Identity());
    recorder.addView(camera, 1, Isometry3d::Identity(), encoded("png"), "png");
  }
  const auto recording = Recording::open(scratch.path());
  EXPECT_EQ(pointsById(recording).size(), 4U);
  EXPECT_EQ(recording.views().size(), 2U);
  EXPECT_EQ(readText(tile).size(), whole.size() + 16);
}

/// Cuts the only tile of a recording to half of its bytes; tells how many points are then left.
std::size_t cutTile(const std::string& directory) {
  const auto path = std::filesystem::directory_iterator(directory + "/tiles")->path();
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  return Recording::open(directory).numPoints();
}

TEST(Recording, ATileThatIsCutLosesPointsAndGetsNone) {
  for (const bool tile_is_open : {true, false}) {
    ScratchDirectory scratch;
    auto params = everything();
    params.voxel_size = 0;
    params.tile_size = 100;
    params.max_open_tiles = 1;
    Recorder recorder(scratch.path(), "map", params);
    const auto atOneSide = [](unsigned seed, double x) {
      auto positions = randomPositions(1000, 10, seed);
      for (auto& position : positions) position += Vector3d(x, 50, 50);
      return positions;
    };
    const auto first = atOneSide(1, 50);
    recorder.addCloud(numbered(first), Isometry3d::Identity());
    recorder.flush();
    const std::size_t num_left = cutTile(scratch.path());
    ASSERT_GT(num_left, 300U);
    ASSERT_LT(num_left, 700U);
    EXPECT_EQ(recorder.snapshot().numPoints(), num_left);
    if (!tile_is_open) recorder.addCloud(numbered(atOneSide(2, -50), 1000), Isometry3d::Identity());
    recorder.addCloud(numbered(atOneSide(3, 50), 2000), Isometry3d::Identity());
    const std::size_t num_points = num_left + (tile_is_open ? 1000 : 2000);
    EXPECT_EQ(recorder.snapshot().numPoints(), num_points);
    EXPECT_EQ(recorder.numPoints(), num_points);
    const auto points = pointsById(Recording::open(scratch.path()));
    EXPECT_EQ(points.size(), num_points);
    for (const auto& [id, position] : points) {
      EXPECT_GT(position.cwiseAbs().minCoeff(), 35) << id;
      EXPECT_TRUE(id >= 1000 || position == first[id].cast<float>());
    }
  }
}

TEST(Recording, AnImageSizeThatNoImageHasIsRefused) {
  ScratchDirectory scratch;
  { Recorder(scratch.path(), "map", everything()).setCamera("camera_0", smallCamera()); }
  const std::string path = scratch / "cameras.yaml";
  const std::string text = readText(path);
  for (const char* width : {"2000000000", "-8", "40000000"}) {
    std::string changed = text;
    changed.replace(changed.find("width: 8"), 8, std::string("width: ") + width);
    writeText(path, changed);
    EXPECT_ERROR(Recording::open(scratch.path()), "cameras.yaml");
    EXPECT_ERROR(Recording::open(scratch.path()), width);
  }
}

TEST(Recording, DamageIsReportedWithTheFile) {
  ScratchDirectory scratch;
  {
    Recorder recorder(scratch.path(), "map", everything());
    recorder.addCloud(numbered({{1, 1, 1}}), Isometry3d::Identity());
    recorder.addView(recorder.setCamera("camera_0", smallCamera()), 0, Isometry3d::Identity(), encoded("png"), "png");
  }
  const auto views = readText(scratch / "views.csv");
  for (const std::string bad : {"0,1,2\n", "0,x,0,0,0,0,0,0,1,i.png\n", "0,1,0,0,0,0,0,0,0,i.png\n"}) {
    writeText(scratch / "views.csv", views + bad);
    EXPECT_ERROR(Recording::open(scratch.path()), "views.csv line 3 is damaged");
  }
  writeText(scratch / "views.csv", views + "7,1,0,0,0,0,0,0,1,i.png\n");
  EXPECT_ERROR(Recording::open(scratch.path()), "camera 7");
  writeText(scratch / "views.csv", views);
  auto tile = readText(scratch / "tiles/0_0_0.pcd");
  tile.replace(tile.find(" id"), 3, " ho");
  writeText(scratch / "tiles/0_0_0.pcd", tile);
  EXPECT_ERROR(Recording::open(scratch.path()), "0_0_0.pcd is damaged");
}

/// Records until it is killed; says through the pipe how many views and points are certainly on the disk.
[[noreturn]] void recordForEver(const std::string& directory, std::uint32_t first_id, int report) {
  auto params = everything();
  params.voxel_size = 0;
  Recorder recorder(directory, "map", params);
  const auto camera = recorder.setCamera("camera_0", smallCamera());
  const auto image = encoded("png");
  for (std::uint32_t id = first_id;; id += 500) {
    recorder.addCloud(numbered(randomPositions(500, 30, id), id), Isometry3d::Identity());
    recorder.addView(camera, id, Isometry3d::Identity(), image, "png");
    recorder.flush();
    const std::uint32_t done = id + 500;
    if (write(report, &done, sizeof done) != sizeof done) _exit(1);
  }
}

TEST(Recording, SurvivesSigkillAtAnyMoment) {
  ScratchDirectory scratch;
  for (int round = 0; round < 8; ++round) {
    const std::uint32_t first_id = static_cast<std::uint32_t>(round) * 10'000'000;
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const auto child = fork();
    if (child == 0) recordForEver(scratch.path(), first_id, pipe_ends[1]);
    close(pipe_ends[1]);
    std::uint32_t done = first_id, next = 0;
    for (int k = 0; k < 3 && read(pipe_ends[0], &next, sizeof next) == sizeof next; ++k) done = next;
    usleep(static_cast<useconds_t>(1700 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (read(pipe_ends[0], &next, sizeof next) == sizeof next) done = next;
    close(pipe_ends[0]);

    const auto recording = Recording::open(scratch.path());
    const auto points = pointsById(recording);
    ASSERT_GT(done, first_id);
    for (std::uint32_t id = first_id; id < done; ++id) ASSERT_EQ(points.count(id), 1U) << id;
    for (const auto& [id, position] : points) {
      const auto start = id / 500 * 500;
      if (id != start) continue;
      EXPECT_EQ(position, randomPositions(500, 30, start)[0].cast<float>());
    }
    for (std::size_t v = 0; v < recording.views().size(); ++v) EXPECT_NO_THROW(recording.readPixels(v));
    EXPECT_GE(recording.views().back().stamp, done - 500);
  }
}

TEST(Recording, FullDiskIsReportedAndLeavesWhatWasThere) {
  ScratchDirectory scratch;
  if (!scratch.mountDisk("size=400k")) GTEST_SKIP() << "no right to mount a small disk";
  const auto directory = scratch / "recording";
  auto params = everything();
  params.voxel_size = 0;
  params.tile_size = 10;
  auto recorder = std::make_unique<Recorder>(directory, "map", params);
  const auto camera = recorder->setCamera("camera_0", smallCamera());
  recorder->addView(camera, 0, Isometry3d::Identity(), encoded("png"), "png");
  recorder->addCloud(numbered(randomPositions(5000, 9, 1)), Isometry3d::Identity());
  const auto before = pointsById(recorder->snapshot());
  EXPECT_ERROR(recorder->addCloud(numbered(randomPositions(100000, 9, 2), 5000), Isometry3d::Identity());
               recorder->flush(), "No space left on device");
  EXPECT_ERROR(
      for (int i = 1; i < 1000; ++i) recorder->addView(camera, i, Isometry3d::Identity(), Bytes(4000, 1), "png"),
      "No space left on device");
  recorder.reset();
  const auto recording = Recording::open(directory);
  const auto after = pointsById(recording);
  for (const auto& [id, position] : before) EXPECT_EQ(after.at(id), position);
  EXPECT_EQ(cv::norm(recording.readPixels(0).image, cv::Mat(6, 8, CV_8UC3, cv::Scalar(30, 20, 10))), 0);
}

}  // namespace
}  // namespace cloud_colorizer
