// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/color_and_save.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

TEST(ColorAndSave, ANameThatTheFormatCannotHoldIsToldBeforeTheWork) {
  ScratchDirectory scratch;
  Recorder recorder(scratch / "r", "map", {});
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xd::Constant(3, 1, 5);
  cloud.fields = {{"echo", FieldType::kFloat32, 2}, {"echo_0", FieldType::kFloat32, 1}};  // as a PLY spells the array
  cloud.records.resize(12);
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  const auto camera = recorder.setCamera("camera_0", {8, 8, 8, 8, 4, 4, DistortionModel::kPlumbBob, {}});
  recorder.addView(camera, 0, Eigen::Isometry3d::Identity(), {1}, "png");
  CommandLine line;
  line.options["output"] = scratch / "map.ply";
  EXPECT_ERROR(colorAndSave(recorder.snapshot(), line, {}), "echo_0");
  EXPECT_FALSE(std::filesystem::exists(scratch / "r/surfels"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "map.ply"));
}

TEST(ColorAndSave, ColoursThatCannotBeRightAreNoSuccess) {
  ColorizeSummary summary;
  summary.num_points = summary.num_colored = 1000;
  summary.disagreement = 0.5;
  EXPECT_NO_THROW(requireColored(summary));
  summary.disagreement = 0.8;
  EXPECT_THROW(requireColored(summary), NothingColored);
}

}  // namespace
}  // namespace cloud_colorizer
