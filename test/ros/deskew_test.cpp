// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/deskew.hpp"

#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/collector.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

template <class Number>
Cloud cloudWithTimes(const char* name, FieldType type, const std::vector<Number>& times) {
  Cloud cloud;
  cloud.fields = {{"ring", FieldType::kUint16, 1}, {name, type, 1}};
  cloud.positions = Eigen::Matrix3Xd::Ones(3, static_cast<Eigen::Index>(times.size()));
  for (const Number& time : times) {
    std::uint8_t record[2 + sizeof(Number)] = {};
    std::memcpy(record + 2, &time, sizeof time);
    cloud.records.insert(cloud.records.end(), record, record + sizeof record);
  }
  return cloud;
}

TEST(PointTimes, AreReadInTheUnitsOfDrivers) {
  const double stamp = 1700000000.25;
  const auto expect = [&](const std::optional<PointTimes>& times, const char* unit, double first, double last) {
    ASSERT_TRUE(times);
    EXPECT_EQ(times->unit, unit);
    EXPECT_NEAR(times->first, first, 1e-6);
    EXPECT_NEAR(times->last, last, 1e-6);
  };
  expect(pointTimes(cloudWithTimes<float>("time", FieldType::kFloat32, {-0.09F, 0, -0.01F}), stamp), "s", -0.09, 0);
  expect(pointTimes(cloudWithTimes<std::uint32_t>("t", FieldType::kUint32, {0, 99000000}), stamp), "ns", 0, 0.099);
  expect(pointTimes(cloudWithTimes<double>("timestamp", FieldType::kFloat64, {stamp, stamp + 0.1}), stamp), "s", 0,
         0.1);
  expect(
      pointTimes(cloudWithTimes<double>("timestamp", FieldType::kFloat64, {stamp * 1e9, (stamp + 0.1) * 1e9}), stamp),
      "ns", 0, 0.1);
  expect(pointTimes(cloudWithTimes<float>("Time", FieldType::kFloat32, {0, 99.5F}), stamp), "ms", 0, 0.0995);
  // By the LiDAR's own clock, since it was switched on.
  expect(pointTimes(cloudWithTimes<double>("timestamp", FieldType::kFloat64, {1234.5, 1234.6}), stamp), "s", 0, 0.1);
}

TEST(PointTimes, WhatTellsOfNoSweepIsNone) {
  EXPECT_FALSE(pointTimes(cloudWithTimes<float>("intensity", FieldType::kFloat32, {0, 0.1F}), 0));
  EXPECT_FALSE(pointTimes(cloudWithTimes<float>("time", FieldType::kFloat32, {0, 0}), 0));
  EXPECT_FALSE(pointTimes(cloudWithTimes<float>("time", FieldType::kFloat32, {}), 0));
  EXPECT_FALSE(pointTimes(cloudWithTimes<float>("time", FieldType::kFloat32, {0, std::nanf("")}), 0));
}

/// A LiDAR that turns ten times a second, in a room of 30 x 20 x 6 m, on a vehicle that drives and turns.
class DeskewTest : public testing::Test {
 protected:
  static constexpr double kStart = 1000, kSweep = 0.1;  // s
  static constexpr int kAzimuths = 360, kBeams = 12;

  DeskewTest() {
    params_.record.voxel_size = 0;
    params_.record.min_range = 0;
  }

  static Isometry3d mapFromLidar(double time) {
    const double since = time - kStart;
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.6 * since, Vector3d::UnitZ()).toRotationMatrix();
    pose.translation() = Vector3d(-4 + 3 * since, -2 + since, 0);
    return pose;
  }

  static double distanceToWalls(const Vector3d& point) { return (half() - point.cwiseAbs()).cwiseAbs().minCoeff(); }
  static Vector3d half() { return {15, 10, 3}; }

  /// In the LiDAR's frame: of each moment, or of the stamp.
  static sensor_msgs::PointCloud2ConstPtr sweep(double stamp, bool skewed) {
    Cloud cloud;
    cloud.fields = {{"t", FieldType::kUint32, 1}};
    cloud.positions.resize(3, kAzimuths * kBeams);
    for (int i = 0; i < kAzimuths * kBeams; ++i) {
      const double share = static_cast<double>(i / kBeams) / kAzimuths, up = -0.5 + 0.09 * (i % kBeams);
      const Isometry3d pose = mapFromLidar(stamp + share * kSweep);
      const Vector3d ray = pose.linear() * Vector3d(std::cos(up) * std::cos(2 * M_PI * share),
                                                    std::cos(up) * std::sin(2 * M_PI * share), std::sin(up));
      const Eigen::Array3d ranges = (half().array() * ray.array().sign() - pose.translation().array()) / ray.array();
      const Vector3d hit = pose.translation() + ranges.minCoeff() * ray;
      cloud.positions.col(i) = (skewed ? pose : mapFromLidar(stamp)).inverse() * hit;
      const auto time = static_cast<std::uint32_t>(share * kSweep * 1e9);
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&time);
      cloud.records.insert(cloud.records.end(), bytes, bytes + 4);
    }
    auto message = boost::make_shared<sensor_msgs::PointCloud2>();
    appendToMessage(cloud, *message);
    message->header.stamp.fromSec(stamp);
    message->header.frame_id = "lidar";
    return message;
  }

  static void addPose(Collector& collector, double stamp) {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(tf2::eigenToTransform(mapFromLidar(stamp)));
    message.transforms[0].header.stamp.fromSec(stamp);
    message.transforms[0].header.frame_id = "map";
    message.transforms[0].child_frame_id = "lidar";
    collector.addTransforms(message, false);
  }

  /// Of two sweeps.
  static void addPoses(Collector& collector, double stamp) {
    for (int k = 0; k < 20; ++k) addPose(collector, stamp + 0.01 * k);
  }

  /// Share of the recorded points that are on a wall.
  double recorded(bool skewed) {
    Recorder recorder(scratch_ / "recording", "map", params_.record);
    CollectorEvents events;
    events.log = [this](LogLevel, const std::string& text) { log_ += text + '\n'; };
    Collector collector(recorder, params_, events);
    for (int i = 0; i < 25; ++i) {
      const double stamp = kStart + i * kSweep;
      collector.addCloud(sweep(stamp, skewed));
      addPoses(collector, stamp);
      collector.process();
    }
    collector.finish();
    EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), 25U);
    const Recording recording = recorder.snapshot();
    double near = 0;
    for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
      const Points points = recording.readPoints(tile);
      for (Eigen::Index i = 0; i < points.cols(); ++i) near += distanceToWalls(points.col(i).cast<double>()) < 0.01;
    }
    return near / static_cast<double>(recording.numPoints());
  }

  ScratchDirectory scratch_;
  CollectorParams params_;
  std::string log_;
};

TEST_F(DeskewTest, MotionThatIsInTheCloudsIsUndone) {
  EXPECT_GT(recorded(true), 0.999);
  EXPECT_NE(log_.find("field t [ns]"), std::string::npos) << log_;
  EXPECT_NE(log_.find("it is undone"), std::string::npos) << log_;
}

TEST_F(DeskewTest, MotionThatWasUndoneBeforeIsNotUndoneAgain) {
  EXPECT_GT(recorded(false), 0.999);
  EXPECT_NE(log_.find("taken as they came"), std::string::npos) << log_;
}

TEST_F(DeskewTest, ItCanBeSwitchedOnAndOff) {
  params_.deskew = "off";
  EXPECT_LT(recorded(true), 0.7);  // floor and ceiling do not tell
  std::filesystem::remove_all(scratch_ / "recording");
  params_.deskew = "on";
  EXPECT_LT(recorded(false), 0.7);
  EXPECT_EQ(log_, "");
  params_.deskew = "perhaps";
  EXPECT_ERROR(recorded(false), "deskew");
}

/// Poses of keyframes only: those of the stamps are there, those of the sweeps lie in gaps.
TEST_F(DeskewTest, WithGapsBetweenTheStampsAutoTakesTheCloudsAsTheyCame) {
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Collector collector(recorder, params_, {});
  for (int i = 0; i < 4; ++i) {
    const double stamp = kStart + i;
    addPose(collector, stamp);
    collector.addCloud(sweep(stamp, true));
    collector.process();
  }
  collector.finish();
  EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), 4U);
}

/// A map is asked for before there is enough to tell.
TEST_F(DeskewTest, SettlingRecordsWhatWaitsForFurtherClouds) {
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Collector collector(recorder, params_, {});
  for (int i = 0; i < 5; ++i) {
    addPoses(collector, kStart + i * kSweep);
    collector.addCloud(sweep(kStart + i * kSweep, true));
    collector.process();
  }
  EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), 0U);
  collector.settle();
  EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), 5U);
}

/// tf often ends with the last cloud's stamp.
TEST_F(DeskewTest, WithoutPosesForTheWholeSweepAutoTakesTheCloudAsItCame) {
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Collector collector(recorder, params_, {});
  addPose(collector, kStart);
  collector.addCloud(sweep(kStart, true));
  collector.finish();
  EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), 1U);
}

}  // namespace
}  // namespace cloud_colorizer
