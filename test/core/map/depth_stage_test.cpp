// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

TEST(RenderDepth, LooksFromThePoseThatIsAskedFor) {
  ScratchDirectory scratch;
  RecordParams record;
  record.voxel_size = 0;
  record.tile_size = 1;
  Recorder recorder(scratch / "r", "map", record);
  Cloud wall;  // 5 m behind the recorded view, which looks along z
  wall.positions.resize(3, 1600);
  for (Eigen::Index i = 0; i < 1600; ++i) {
    wall.positions.col(i) << 0.1 * static_cast<double>(i % 40) - 2, 0.1 * static_cast<double>(i / 40) - 2, -5;
  }
  recorder.addCloud(wall, Eigen::Isometry3d::Identity());
  const auto camera = recorder.setCamera("camera_0", {100, 100, 100, 100, 49.5, 49.5, DistortionModel::kPlumbBob, {}});
  recorder.addView(camera, 0, Eigen::Isometry3d::Identity(), {1}, "png");
  Workspace work(recorder.snapshot(), {});
  const Stage surfels = surfelStage();
  work.files().claim(surfels.folder, surfels.key(work));
  surfels.run(work, {0, surfels.units(work).size()}, {});

  const auto depthAhead = [&](const Eigen::Isometry3d& pose) { return renderDepth(work, 0, pose, {}).depth(25, 25); };
  EXPECT_TRUE(std::isinf(depthAhead(Eigen::Isometry3d::Identity())));
  EXPECT_NEAR(depthAhead(Eigen::Isometry3d(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()))), 5, 0.1);
}

}  // namespace
}  // namespace cloud_colorizer
