// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/parts.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

TEST(UnitsOfPart, AreNeighboursAndEachInOnePart) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> units(random() % 40);
    for (double& unit : units) unit = static_cast<double>(random() % 5);
    const std::size_t count = 1 + random() % 12;
    std::size_t next = 0;
    for (std::size_t index = 1; index <= count; ++index) {
      const UnitRange range = unitsOfPart(units, {index, count});
      EXPECT_EQ(range.first, next);
      EXPECT_LE(range.first, range.last);
      next = range.last;
    }
    EXPECT_EQ(next, units.size());
  }
}

TEST(UnitsOfPart, HaveAsMuchToDo) {
  std::vector<double> units(1000);
  for (std::size_t i = 0; i < units.size(); ++i) units[i] = 1 + static_cast<double>(i % 7);
  const double all = std::accumulate(units.begin(), units.end(), 0.0);
  for (std::size_t index = 1; index <= 8; ++index) {
    const UnitRange range = unitsOfPart(units, {index, 8});
    const auto begin = units.begin();
    const double work = std::accumulate(begin + static_cast<std::ptrdiff_t>(range.first),
                                        begin + static_cast<std::ptrdiff_t>(range.last), 0.0);
    EXPECT_NEAR(work, all / 8, 7);
  }
}

TEST(Part, IsReadOrRefused) {
  EXPECT_EQ(parsePart("2/8").index, 2U);
  EXPECT_EQ(parsePart("2/8").count, 8U);
  for (const char* text : {"", "2", "0/4", "5/4", "/4", "1/", "1/x", "-1/4", "1/4/2", "1.5/2"}) {
    EXPECT_THROW(parsePart(text), std::invalid_argument) << text;
  }
}

/// A corridor of ten tiles, seen by six views, one of them damaged.
class Parts : public ::testing::Test {
 protected:
  Parts() {
    params_.chunks.max_chunk_points = 1000;
    params_.colorize.num_threads = 1;
  }

  Recording record(const std::string& name) {
    RecordParams record;
    record.voxel_size = 0, record.min_range = 0, record.max_range = 100, record.tile_size = 1;
    Recorder recorder(scratch_ / name, "map", record);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> along(0, 10), across(-0.5, 0.5), noise(-0.005, 0.005);
    Cloud cloud;
    cloud.positions.resize(3, 9000);
    for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
      cloud.positions.col(i) << along(random), across(random), 2 + noise(random);
    }
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", {96, 64, 60, 60, 47.5, 31.5, DistortionModel::kPlumbBob, {}});
    for (int view = 0; view < 6; ++view) {
      cv::Mat3b image(64, 96);
      cv::RNG(7 + view).fill(image, cv::RNG::UNIFORM, 20, 230);
      cv::GaussianBlur(image, image, {}, 3);
      std::vector<std::uint8_t> png;
      cv::imencode(".png", image, png);
      if (view == 4) png.resize(png.size() / 2);
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation().x() = 1 + 1.6 * view;
      recorder.addView(camera, view, pose, png, "png");
    }
    return recorder.snapshot();
  }

  std::string saved(const Recording& recording, const std::string& name) {
    saveColored(recording, params_, scratch_ / name, {});
    return readText(scratch_ / name);
  }

  ScratchDirectory scratch_;
  Params params_;
};

TEST_F(Parts, DoneAtTheSameTimeGiveTheBytesOfOneRun) {
  for (const Method method : {Method::kPaper, Method::kDefault}) {
    params_.colorize.method = method;
    const std::string run = std::to_string(static_cast<int>(method));
    const Recording whole = record("whole" + run), parts = record("parts" + run);
    const ColorizeSummary expected = colorize(whole, params_, {});
    EXPECT_EQ(expected.num_damaged_views, 1U);
    for (const PlannedStage& stage : planStages(parts, params_, {})) {
      EXPECT_GT(stage.num_units, 0U);
      EXPECT_EQ(stage.num_done, 0U);
      std::vector<std::thread> programs;
      for (std::size_t index : {3, 1, 2, 2}) {  // in any order, one of them twice
        programs.emplace_back([&, index] { runPart(parts, params_, stage.name, {index, 3}, {}); });
      }
      for (std::thread& program : programs) program.join();
    }
    for (const PlannedStage& stage : planStages(parts, params_, {})) EXPECT_EQ(stage.num_done, stage.num_units);
    const ColorizeSummary summary = mergeParts(parts, params_, {});
    EXPECT_EQ(summary.num_colored, expected.num_colored);
    EXPECT_GT(summary.num_colored, 5000U);
    EXPECT_EQ(saved(parts, "parts.ply"), saved(whole, "whole.ply"));
    EXPECT_FALSE(std::filesystem::exists(parts.directory() + "/decoded"));
  }
}

TEST_F(Parts, AStageWaitsForThoseBeforeIt) {
  const Recording recording = record("r");
  EXPECT_ERROR(runPart(recording, params_, "depth", {1, 2}, {}), "/r --stage images");
  runPart(recording, params_, "images", {1, 1}, {});
  runPart(recording, params_, "surfels", {1, 2}, {});
  EXPECT_ERROR(runPart(recording, params_, "depth", {1, 2}, {}), "of the stage surfels, ");
  EXPECT_ERROR(mergeParts(recording, params_, {}), "of the stage surfels");
  EXPECT_ERROR(runPart(recording, params_, "surfel", {1, 2}, {}), "unknown stage 'surfel'; known are images, ");
}

TEST_F(Parts, OtherParametersBeginAnew) {
  const Recording recording = record("r");
  const auto doneOf = [&](const std::string& name) {
    for (const PlannedStage& stage : planStages(recording, params_, {})) {
      if (stage.name == name) return stage.num_done;
    }
    return std::size_t{99};
  };
  for (const char* stage : {"images", "surfels"}) runPart(recording, params_, stage, {1, 1}, {});
  EXPECT_GT(doneOf("surfels"), 0U);
  params_.depth.clear_radius = 1;
  EXPECT_EQ(doneOf("surfels"), 0U);
  EXPECT_GT(doneOf("images"), 0U);
}

}  // namespace
}  // namespace cloud_colorizer
