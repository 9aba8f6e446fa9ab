// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/derived_files.hpp"

#include <gtest/gtest.h>
#include <sys/mount.h>

#include <filesystem>
#include <functional>
#include <random>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

/// One tile of seven points, and three views.
class DerivedFilesTest : public ::testing::Test {
 protected:
  DerivedFilesTest() : files_(record()) {
    for (const char* folder : {"surfels", "depth", "colored", "alignment", "damaged_images"}) files_.claim(folder, "k");
    surfels_ = {Eigen::Matrix3Xf::Random(3, 7), Eigen::VectorXf::Random(7), Eigen::VectorXf::Random(7),
                Eigen::VectorXf::Random(7)};
    for (const Eigen::Index count : {3, 1}) {
      const Points points = Points::Random(3, count);
      const Eigen::VectorXf numbers = Eigen::VectorXf::Random(count);
      thinned_.push_back({0.5F / static_cast<float>(count), {points, {points, numbers, numbers, numbers}}});
    }
    image_.depth = cv::Mat1f(5, 4, 3.F);
    image_.edge = cv::Mat1b(5, 4, std::uint8_t{0});
    image_.edge(2, 3) = 255;
    image_.cell_size = 2;
    colors_ = {Values::Random(3, 7),
               {1, 2, 3, 4, 5, 6, 7},
               {1, 2, 3, 4, 5, 6, 7},
               std::vector<Unseen>(7, Unseen::kAbsent),
               {{1, 2, 3}, {4, 5, 6}, {}, {}, {}, {}, {9, 9, 9}},
               {1, 0, 2, 0, 0, 0, 3},
               {},
               {},
               Values(0, 7)};
    corrections_.resize(3);
    corrections_[1].map_from_camera.translation() << 1, 2, 3;
    corrections_[1].exposure.gain = Eigen::Array3f(1, 2, 3);
    corrections_[2].weight = 0.5F;
  }

  Recording record() {
    RecordParams params;
    params.voxel_size = 0;
    params.min_range = 0;
    Recorder recorder(scratch_ / "r", "map", params);
    Cloud cloud;
    cloud.positions = Eigen::Matrix3Xd::Random(3, 7).cwiseAbs();
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", {8, 8, 8, 8, 4, 4, DistortionModel::kPlumbBob, {}});
    for (int i = 0; i < 3; ++i) recorder.addView(camera, i, Eigen::Isometry3d::Identity(), {1}, "png");
    return recorder.snapshot();
  }

  void writeAll() {
    files_.writeSurfels(0, surfels_, thinned_);
    files_.writeDepth(2, image_);
    files_.writeColors(0, colors_, {tone_, held_out_});
    files_.writeCorrections(corrections_);
    files_.writeDamagedViews(0, {1, 2});
  }

  ScratchDirectory scratch_;
  DerivedFiles files_;
  Surfels surfels_;
  std::vector<ThinnedSurface> thinned_;
  DepthImage image_;
  TileColors colors_;
  ToneCells tone_ = {{{-1, 0, 2}, {{{0, 0.5}, {2, 3}}, 4}}, {{0, 0, 0}, {{{1, 1}}, 8}}};
  std::vector<HeldOut> held_out_ = {{1, 20, 7}};
  std::vector<CorrectedView> corrections_;
};

TEST_F(DerivedFilesTest, ReadBackWhatWasWritten) {
  EXPECT_FALSE(files_.hasSurfels(0) || files_.hasDepth(2) || files_.hasColors(0) || files_.readCorrections() ||
               files_.readDamagedViews(0));
  writeAll();
  EXPECT_TRUE(files_.hasSurfels(0) && files_.hasDepth(2) && files_.hasColors(0));
  EXPECT_EQ(files_.readSurfels(0).normals, surfels_.normals);
  EXPECT_EQ(files_.readSurfels(0).offsets, surfels_.offsets);
  EXPECT_EQ(files_.readSurfels(0).thicknesses, surfels_.thicknesses);
  const std::vector<float> thicknesses = files_.readThicknesses(0);
  EXPECT_TRUE(std::equal(thicknesses.begin(), thicknesses.end(), surfels_.thicknesses.data()));
  const std::vector<ThinnedLevel> levels = files_.thinnedLevels(0);
  ASSERT_EQ(levels.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(levels[k].cell, thinned_[k].cell);
    EXPECT_EQ(files_.readThinned(0, levels[k]).points, thinned_[k].surface.points);
    EXPECT_EQ(files_.readThinned(0, levels[k]).surfels.thicknesses, thinned_[k].surface.surfels.thicknesses);
  }
  const DepthImage image = files_.readDepth(2);
  EXPECT_EQ(cv::countNonZero(image.depth != image_.depth) + cv::countNonZero(image.edge != image_.edge), 0);
  EXPECT_EQ(image.cell_size, 2);
  const TileColors colors = files_.readColors(0);
  EXPECT_EQ(colors.values, colors_.values);
  EXPECT_EQ(colors.count, colors_.count);
  EXPECT_EQ(colors.unseen, colors_.unseen);
  EXPECT_EQ(colors.nearest, colors_.nearest);
  EXPECT_EQ(colors.camera, colors_.camera);
  const auto [tone, held_out] = files_.readViews(0);
  ASSERT_EQ(held_out.size(), 1U);
  EXPECT_EQ(held_out[0].error, held_out_[0].error);
  ASSERT_EQ(tone.size(), 2U);
  EXPECT_EQ(tone.begin()->first, (ToneCell{-1, 0, 2}));
  EXPECT_EQ(tone.begin()->second.peak, 4);
  EXPECT_EQ(tone.begin()->second.views, tone_.begin()->second.views);
  const auto corrections = *files_.readCorrections();
  EXPECT_EQ(corrections[1].map_from_camera.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(corrections[1].exposure.gain[2], 3);
  EXPECT_EQ(corrections[2].weight, 0.5F);
  EXPECT_EQ(*files_.readDamagedViews(0), (ViewList{1, 2}));
}

/// A bit turned, a piece zeroed, cut, lengthened, or emptied.
void damage(const std::string& path, std::mt19937& random) {
  std::string bytes = readText(path);
  const std::string before = bytes;
  while (bytes == before) {
    const std::size_t at = random() % bytes.size();
    const auto kind = random() % 5;
    if (kind == 0) bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
    if (kind == 1)
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(16, bytes.size() - at), '\0');
    if (kind == 2) bytes.resize(at);
    if (kind == 3) bytes += bytes.substr(at);
    if (kind == 4) bytes.clear();
  }
  writeText(path, bytes);
}

TEST_F(DerivedFilesTest, WhatIsDamagedCountsAsAbsentAndIsNeverRead) {
  const std::vector<std::pair<std::string, std::function<bool()>>> kinds = {
      {"surfels/0_0_0.bin", [&] { return files_.hasSurfels(0); }},
      {"surfels/0_0_0.thinned", [&] { return files_.hasSurfels(0); }},
      {"depth/000002.bin", [&] { return files_.hasDepth(2); }},
      {"colored/0_0_0.bin", [&] { return files_.hasColors(0); }},
      {"colored/0_0_0.views", [&] { return files_.hasColors(0); }},
      {"alignment/views.bin", [&] { return files_.readCorrections().has_value(); }},
      {"damaged_images/000000.bin", [&] { return files_.readDamagedViews(0).has_value(); }},
      {"depth/key.txt", [&] { return files_.holds("depth", "k"); }}};
  std::mt19937 random(1);
  for (const auto& [name, is_whole] : kinds) {
    for (int round = 0; round < 200; ++round) {
      writeAll();
      writeText(files_.pathOf("depth/key.txt"), "k");
      ASSERT_TRUE(is_whole());
      damage(files_.pathOf(name), random);
      EXPECT_FALSE(is_whole()) << name;
    }
  }
  damage(files_.pathOf("colored/0_0_0.bin"), random);
  for (const std::size_t size : {0, 15, 40}) {  // of surfels and depth images the size alone is looked at again
    writeText(files_.pathOf("depth/000002.bin"), std::string(size, '\1'));
    writeText(files_.pathOf("surfels/0_0_0.bin"), std::string(size, '\1'));
    EXPECT_ERROR(files_.readDepth(2), "depth/000002.bin");
    EXPECT_ERROR(files_.readSurfels(0), "surfels/0_0_0.bin");
  }
  EXPECT_ERROR(files_.readColors(0), "colored/0_0_0.bin");
}

TEST_F(DerivedFilesTest, AFolderOfAnotherKeyIsEmptied) {
  writeAll();
  files_.claim("colored", "k");
  EXPECT_TRUE(files_.hasColors(0));
  files_.claim("colored", "another");
  EXPECT_FALSE(files_.hasColors(0));
  EXPECT_TRUE(files_.holds("colored", "another"));
}

TEST_F(DerivedFilesTest, OneColoursOrSeveralRead) {
  const std::string directory = scratch_ / "r";
  {
    const FolderLock colors(directory, true);
    EXPECT_ERROR(FolderLock(directory, false), "another program");
    EXPECT_ERROR(FolderLock(directory, true), "another program");
  }
  const FolderLock reads(directory, false), reads_too(directory, false);
  EXPECT_ERROR(FolderLock(directory, true), "another program");
}

TEST_F(DerivedFilesTest, WhoWaitsGetsTheLockOrIsCancelled) {
  const std::string directory = scratch_ / "r";
  auto reads = std::make_unique<FolderLock>(directory, false);
  int asked = 0;
  Callbacks callbacks;
  callbacks.cancelled = [&] { return ++asked == 3; };
  EXPECT_THROW(FolderLock(directory, true, callbacks), Cancelled);
  callbacks.cancelled = [&] {
    reads.reset();
    return false;
  };
  FolderLock(directory, true, callbacks);
  EXPECT_EQ(reads, nullptr);
}

TEST(FolderLock, ReadsWhereNobodyMayWrite) {
  ScratchDirectory disk;
  if (!disk.mountDisk("size=1m")) GTEST_SKIP() << "no right to mount";
  for (const bool has_lock : {false, true}) {
    ASSERT_EQ(mount(nullptr, disk.path().c_str(), nullptr, MS_REMOUNT, nullptr), 0);
    if (has_lock) FolderLock(disk.path(), true);
    ASSERT_EQ(mount(nullptr, disk.path().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
    EXPECT_NO_THROW(FolderLock(disk.path(), false));
    EXPECT_ERROR(FolderLock(disk.path(), true), "Read-only file system");
  }
}

}  // namespace
}  // namespace cloud_colorizer
