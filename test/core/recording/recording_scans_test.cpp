// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "base/file_io.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Isometry3d;

Isometry3d at(double x, double degrees = 0) {
  Isometry3d pose(Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d::UnitZ()));
  pose.translation().x() = x;
  return pose;
}

RecordParams everyMetre() {
  RecordParams params;
  params.keyframe_distance = 1;
  params.keyframe_angle = 40;
  return params;
}

const Eigen::Matrix3Xd kOneReturn = Eigen::Vector3d(8, 0, 0);

TEST(Scans, AreReadAsTheyWereKept) {
  const ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everyMetre());
  recorder.addScan("lidar", 1317046450.123456789, kOneReturn, at(3, 30));
  const Recording snapshot = recorder.snapshot(), opened = Recording::open(scratch.path());
  for (const Recording& recording : {snapshot, opened}) {
    ASSERT_EQ(recording.scans().size(), 1U);
    EXPECT_DOUBLE_EQ(recording.scans()[0].stamp, 1317046450.123456789);
    EXPECT_TRUE(recording.scans()[0].map_from_sensor.isApprox(at(3, 30), 1e-12));
    EXPECT_EQ(cv::norm(recording.readScan(0), makeRangePanorama(kOneReturn, 0.5, 1)), 0);
  }
}

TEST(Scans, AreKeptAtAQuarterOfTheMotionBetweenKeyframes) {
  const ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everyMetre());
  recorder.addScan("lidar", 1, kOneReturn, at(0));
  recorder.addScan("lidar", 2, kOneReturn, at(0.2));
  recorder.addScan("lidar", 3, kOneReturn, at(0.2, 9));
  recorder.addScan("second", 3, kOneReturn, at(0.2));
  recorder.addScan("lidar", 4, kOneReturn, at(0.26));
  recorder.addScan("lidar", 5, kOneReturn, at(0.26, 11));
  std::vector<double> stamps;
  const Recording recording = recorder.snapshot();
  for (const Scan& scan : recording.scans()) stamps.push_back(scan.stamp);
  EXPECT_EQ(stamps, (std::vector<double>{1, 3, 4, 5}));
}

TEST(Scans, AreRelativeToTheOriginOfAFarMap) {
  const ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everyMetre());
  recorder.addScan("lidar", 1, kOneReturn, at(500250));
  const Recording recording = recorder.snapshot();
  EXPECT_DOUBLE_EQ(recording.origin().x() + recording.scans()[0].map_from_sensor.translation().x(), 500250);
  EXPECT_LE(std::abs(recording.scans()[0].map_from_sensor.translation().x()), 500);
}

TEST(Scans, ResolutionZeroKeepsNone) {
  const ScratchDirectory scratch;
  RecordParams params = everyMetre();
  params.scan_resolution = 0;
  Recorder recorder(scratch.path(), "map", params);
  recorder.addScan("lidar", 1, kOneReturn, at(0));
  EXPECT_TRUE(recorder.snapshot().scans().empty());
  params.scan_resolution = 0.01;
  EXPECT_THROW(params.check(), std::invalid_argument);
}

TEST(Scans, TornTailIsIgnoredAndCutWhenContinued) {
  const ScratchDirectory scratch;
  { Recorder(scratch.path(), "map", everyMetre()).addScan("lidar", 1, kOneReturn, at(0)); }
  const std::string table = scratch.path() + "/scans.csv";
  auto bytes = readFile(table);
  const std::string torn = "2,0.5,0";
  bytes.insert(bytes.end(), torn.begin(), torn.end());
  writeFileAtomically(table, bytes.data(), bytes.size());
  EXPECT_EQ(Recording::open(scratch.path()).scans().size(), 1U);
  Recorder recorder(scratch.path(), "map", everyMetre());
  recorder.addScan("lidar", 3, kOneReturn, at(5));
  const Recording recording = Recording::open(scratch.path());
  ASSERT_EQ(recording.scans().size(), 2U);
  EXPECT_EQ(recording.scans()[1].stamp, 3);
  EXPECT_NE(recording.scans()[0].image, recording.scans()[1].image);
}

TEST(Scans, DamageIsNamedWithTheRemedy) {
  const ScratchDirectory scratch;
  { Recorder(scratch.path(), "map", everyMetre()).addScan("lidar", 1, kOneReturn, at(0)); }
  const Recording recording = Recording::open(scratch.path());
  writeFileAtomically(scratch.path() + "/scans/000000.png", "no image", 8);
  try {
    recording.readScan(0);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("scans/000000.png"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("delete scans.csv"), std::string::npos) << error.what();
  }
  const std::string line = "stamp,x,y,z,qx,qy,qz,qw,ranges\n1,0,0,zero,0,0,0,1,scans/000000.png\n";
  writeFileAtomically(scratch.path() + "/scans.csv", line.data(), line.size());
  EXPECT_THROW(Recording::open(scratch.path()), std::runtime_error);
}

TEST(Scans, BadOnesAreRefused) {
  const ScratchDirectory scratch;
  Recorder recorder(scratch.path(), "map", everyMetre());
  EXPECT_THROW(recorder.addScan("lidar", std::nan(""), kOneReturn, at(0)), std::invalid_argument);
  Isometry3d unknown = Isometry3d::Identity();
  unknown.translation().x() = std::nan("");
  EXPECT_THROW(recorder.addScan("lidar", 1, kOneReturn, unknown), std::invalid_argument);
  EXPECT_TRUE(recorder.snapshot().scans().empty());
}

TEST(Scans, AFileThatClaimsAnImpossibleSizeIsNamed) {
  ScratchDirectory scratch;
  {
    Recorder recorder(scratch.path(), "map", everyMetre());
    recorder.addScan("lidar", 1, kOneReturn, at(0));
  }
  writeText(scratch / "scans/000000.png", "P5\n2000000 2000000\n255\n");  // OpenCV throws without a path
  EXPECT_ERROR(Recording::open(scratch.path()).readScan(0), "scans/000000.png");
}

}  // namespace
}  // namespace cloud_colorizer
