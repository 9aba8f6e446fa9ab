// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/fingerprint.hpp"

#include <gtest/gtest.h>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

class Fingerprint : public ::testing::Test {
 protected:
  /// So many points and views.
  Recording record(const std::string& name, Eigen::Index num_points, int num_views) {
    Recorder recorder(scratch_ / name, "map", {});
    Cloud cloud;
    cloud.positions = Eigen::Matrix3Xd::Constant(3, num_points, 5);
    for (Eigen::Index i = 0; i < num_points; ++i) cloud.positions(0, i) += static_cast<double>(i);
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", {8, 8, 8, 8, 4, 4, DistortionModel::kPlumbBob, {}});
    for (int i = 0; i < num_views; ++i) recorder.addView(camera, i, Eigen::Isometry3d::Identity(), {1}, "png");
    return recorder.snapshot();
  }

  struct Keys {
    std::string surfels, alignment, depth, colors;
  };
  Keys keysOf(const Recording& recording, const ViewList& damaged = {}) const {
    const std::vector<CorrectedView> views(recording.views().size());
    return {surfelsKey(recording, params_), alignmentKey(recording, params_, damaged),
            depthKey(recording, params_, views), colorsKey(recording, params_, damaged, views)};
  }

  ScratchDirectory scratch_;
  Params params_;
};

TEST_F(Fingerprint, TheSameRecordingAndParametersGiveTheSameKeys) {
  record("r", 4, 2);
  const Keys a = keysOf(Recording::open(scratch_ / "r")), b = keysOf(Recording::open(scratch_ / "r"));
  EXPECT_EQ(a.surfels, b.surfels);
  EXPECT_EQ(a.alignment, b.alignment);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.colors, b.colors);
}

TEST_F(Fingerprint, EachParameterReachesTheFilesThatItChanges) {
  const Recording recording = record("r", 4, 2);
  const Keys before = keysOf(recording);
  params_.colorize.num_threads = 7;
  params_.colorize.memory_limit = 300;
  params_.colorize.uncolored = Uncolored::kFill;
  params_.colorize.moving = Moving::kDrop;
  params_.record.scan_resolution = 1;  // of scans that are recorded from now on
  EXPECT_EQ(keysOf(recording).alignment, before.alignment);
  EXPECT_EQ(keysOf(recording).colors, before.colors);

  params_.system.lambda = 2;
  EXPECT_NE(keysOf(recording).colors, before.colors);
  EXPECT_EQ(keysOf(recording).depth, before.depth);
  EXPECT_EQ(keysOf(recording).alignment, before.alignment);

  params_.alignment.pose_rotation_prior = 1;
  EXPECT_NE(keysOf(recording).alignment, before.alignment);
  params_.alignment.pose_rotation_prior = AlignmentParams{}.pose_rotation_prior;
  params_.alignment.align_poses = AlignPoses::kCameras;
  EXPECT_NE(keysOf(recording).alignment, before.alignment);
  EXPECT_EQ(keysOf(recording).depth, before.depth);

  params_.record.scan_resolution = 0;  // none is used
  EXPECT_NE(keysOf(recording).depth, before.depth);
  EXPECT_EQ(keysOf(recording).surfels, before.surfels);

  params_.depth.clear_radius = 0.1;
  EXPECT_NE(keysOf(recording).surfels, before.surfels);
  EXPECT_NE(keysOf(recording).depth, before.depth);
}

TEST_F(Fingerprint, WhatIsRecordedLaterChangesTheKeys) {
  const Keys before = keysOf(record("r", 4, 2));
  const Keys more_points = keysOf(record("points", 5, 2)), more_views = keysOf(record("views", 4, 3));
  EXPECT_NE(more_points.depth, before.depth);
  EXPECT_NE(more_points.alignment, before.alignment);
  EXPECT_NE(more_views.alignment, before.alignment);
  EXPECT_NE(more_views.colors, before.colors);
}

TEST_F(Fingerprint, AViewThatIsLeftOutAndAnImageThatChangesAreSeen) {
  const Recording recording = record("r", 4, 2);
  const Keys all = keysOf(recording), without = keysOf(recording, {1});
  EXPECT_NE(without.alignment, all.alignment);
  EXPECT_NE(without.colors, all.colors);
  const std::string files = imageFilesKey(recording);
  writeText(scratch_ / ("r/" + recording.views()[1].image), "repaired");
  EXPECT_NE(imageFilesKey(recording), files);
}

}  // namespace
}  // namespace cloud_colorizer
