// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A program that records is killed and starts again with the same input: the recording is that of an undisturbed run.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kClouds = 25;

Cloud cloudOf(int number) {
  std::mt19937 random(static_cast<unsigned>(number));
  std::uniform_real_distribution<double> uniform(-6, 6);
  Cloud cloud;
  cloud.positions.resize(3, 150);
  for (auto& value : cloud.positions.reshaped()) value = uniform(random);
  cloud.fields = {{"id", FieldType::kUint32}};
  cloud.records.resize(4 * 150);
  for (std::size_t i = 0; i < cloud.records.size(); ++i) cloud.records[i] = static_cast<std::uint8_t>(number);
  return cloud;
}

Eigen::Isometry3d poseOf(int number) {
  return Eigen::Isometry3d(Eigen::Translation3d(0.1 * number, 0, 0));
}

RecordParams paramsWith(double voxel_size) {
  RecordParams params;
  params.voxel_size = voxel_size;
  params.tile_size = 2;  // many tiles, so that a kill comes between two of them
  params.min_range = 0;
  return params;
}

/// What colorize_bag does with a bag: two cameras, and a view of each with every second cloud.
void recordAll(const std::string& directory, double voxel_size, int begin = 0, int end = kClouds) {
  Recorder recorder(directory, "map", paramsWith(voxel_size));
  const Intrinsics intrinsics = {8, 6, 10, 11, 3.5, 2.5, DistortionModel::kPlumbBob, {}};
  const std::uint32_t cameras[2] = {recorder.setCamera("camera_0", intrinsics),
                                    recorder.setCamera("camera_1", intrinsics)};
  std::vector<std::uint8_t> image;
  cv::imencode(".png", cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)), image);
  for (int i = begin; i < end; ++i) {
    const CloudSource source = {"li,dar\n", 1700000000.1 + 0.1 * i};
    const Cloud cloud = cloudOf(i);
    if (!recorder.recognizeCloud(source)) recorder.addCloud(cloud, poseOf(i), source);
    recorder.addScan(source.sensor, source.stamp, cloud.positions, poseOf(i));
    for (const std::uint32_t camera : cameras) {
      const bool is_new = i % 2 == 0 && !recorder.recognizeView(camera, source.stamp);
      if (is_new) recorder.addView(camera, source.stamp, poseOf(i), image, "png");
    }
    recorder.flush();
  }
}

/// Name to content of all files, but for what a torn write left beside them.
std::map<std::string, std::string> contentOf(const std::string& directory) {
  std::map<std::string, std::string> content;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".tmp") continue;
    content[std::filesystem::relative(entry.path(), directory)] = readText(entry.path());
  }
  return content;
}

void expectSame(const std::string& directory, const std::string& other) {
  const auto content = contentOf(directory), expected = contentOf(other);
  for (const auto& [name, bytes] : expected) {
    EXPECT_TRUE(content.count(name) > 0 && content.at(name) == bytes) << name << " differs";
  }
  EXPECT_EQ(content.size(), expected.size());
}

void recordAndDieAfter(int microseconds, const std::string& directory, double voxel_size) {
  const pid_t child = fork();
  if (child == 0) {
    recordAll(directory, voxel_size);
    _exit(0);
  }
  usleep(static_cast<unsigned>(microseconds));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
}

class Resume : public testing::TestWithParam<double> {};

TEST_P(Resume, KilledAnywhereGivesTheSameBytes) {
  ScratchDirectory scratch;
  const auto start = std::chrono::steady_clock::now();
  recordAll(scratch / "whole", GetParam());
  const std::chrono::duration<double, std::micro> whole = std::chrono::steady_clock::now() - start;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const std::string directory = scratch / std::to_string(attempt);
    const int moment = static_cast<int>(whole.count() * (attempt + 0.5) / 12);
    recordAndDieAfter(moment, directory, GetParam());
    if (attempt % 3 == 0) recordAndDieAfter(moment / 2, directory, GetParam());
    recordAll(directory, GetParam());
    expectSame(directory, scratch / "whole");
  }
}

TEST_P(Resume, LaterInputIsAppended) {
  ScratchDirectory scratch;
  recordAll(scratch / "whole", GetParam(), 0, 10);
  recordAll(scratch / "whole", GetParam(), 10, 20);
  recordAll(scratch / "parts", GetParam(), 0, 5);
  recordAll(scratch / "parts", GetParam(), 0, 10);
  recordAll(scratch / "parts", GetParam(), 10, 20);
  expectSame(scratch / "parts", scratch / "whole");
}

INSTANTIATE_TEST_SUITE_P(VoxelSizes, Resume, testing::Values(0.0, 0.5));

/// A bag that is played in a loop has each stamp more than once.
TEST(Resume, EachIsRecognizedAsOftenAsItWasRecorded) {
  ScratchDirectory scratch;
  const CloudSource source = {"lidar", 12.5}, other = {"radar", 12.5};
  {
    Recorder recorder(scratch.path(), "map", paramsWith(0));
    for (int i = 0; i < 2; ++i) recorder.addCloud(cloudOf(0), poseOf(0), source);
    EXPECT_FALSE(recorder.recognizeCloud(source)) << "only what an earlier program recorded";
  }
  Recorder recorder(scratch.path(), "map", paramsWith(0));
  EXPECT_FALSE(recorder.recognizeCloud(other));
  EXPECT_TRUE(recorder.recognizeCloud(source));
  EXPECT_TRUE(recorder.recognizeCloud(source));
  EXPECT_FALSE(recorder.recognizeCloud(source));
}

/// Two lidars on one clock measure at the same moment.
TEST(Resume, ScansOfOneStampAreToldApartByTheirPoses) {
  ScratchDirectory scratch;
  const Cloud cloud = cloudOf(0);
  {
    Recorder recorder(scratch.path(), "map", paramsWith(0));
    recorder.addScan("left", 1, cloud.positions, poseOf(0));
  }
  Recorder recorder(scratch.path(), "map", paramsWith(0));
  recorder.addScan("left", 1, cloud.positions, poseOf(0));
  recorder.addScan("right", 1, cloud.positions, poseOf(5));
  EXPECT_EQ(recorder.snapshot().scans().size(), 2U);
}

}  // namespace
}  // namespace cloud_colorizer
