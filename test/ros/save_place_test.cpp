// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/save_place.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

/// A directory `maps`, and `other` beside it.
class SavePlaceTest : public testing::Test {
 protected:
  SavePlaceTest() {
    fs::create_directories(maps_ + "/sub");
    fs::create_directories(other_);
  }

  void touch(const std::string& file) const { std::ofstream(file) << "old"; }

  /// What refuses the path; empty: it is taken.
  std::string refusal(const std::string& path, bool overwrite = false) const {
    try {
      place().resolve(path, overwrite);
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }
  void expectRefused(const std::string& path, const std::string& because, bool overwrite = false) const {
    EXPECT_NE(refusal(path, overwrite).find(because), std::string::npos) << path << ": " << refusal(path, overwrite);
  }
  SavePlace& place() const {
    if (!place_) place_ = std::make_unique<SavePlace>(maps_);
    return *place_;
  }

  ScratchDirectory scratch_;
  std::string maps_ = scratch_.path() + "/maps", other_ = scratch_.path() + "/other";
  mutable std::unique_ptr<SavePlace> place_;
};

TEST_F(SavePlaceTest, RelativePathsAreBelowTheDirectory) {
  EXPECT_EQ(place().resolve("a.ply", false), fs::canonical(maps_).string() + "/a.ply");
  EXPECT_EQ(place().resolve("sub/../sub/a.pcd", false), fs::canonical(maps_).string() + "/sub/a.pcd");
  EXPECT_EQ(place().resolve(maps_ + "/a.ply", false), fs::canonical(maps_).string() + "/a.ply");
}

TEST_F(SavePlaceTest, PathsThatLeaveTheDirectoryAreRefused) {
  expectRefused("../a.ply", "~save_dir");
  expectRefused("sub/../../other/a.ply", "outside");
  expectRefused(other_ + "/a.ply", "outside");
  fs::create_directory(maps_ + "_2");  // begins with the same letters
  expectRefused(maps_ + "_2/a.ply", "outside");
}

TEST_F(SavePlaceTest, LinksAreFollowedBeforeTheyAreJudged) {
  fs::create_directory_symlink(other_, maps_ + "/away");
  expectRefused("away/a.ply", "outside");
  fs::create_directory_symlink(maps_ + "/sub", maps_ + "/within");
  EXPECT_EQ(place().resolve("within/a.ply", false), fs::canonical(maps_).string() + "/sub/a.ply");
}

TEST_F(SavePlaceTest, ADirectoryBehindALinkIsTheOneMeant) {
  fs::create_directory_symlink(maps_, scratch_.path() + "/link");
  const SavePlace linked(scratch_.path() + "/link");
  EXPECT_EQ(linked.resolve("a.ply", false), fs::canonical(maps_).string() + "/a.ply");
}

TEST_F(SavePlaceTest, OnlyRegularFilesAreReplaced) {
  ASSERT_EQ(mkfifo((maps_ + "/fifo.ply").c_str(), 0600), 0);
  touch(other_ + "/target.ply");
  fs::create_symlink(other_ + "/target.ply", maps_ + "/link.ply");
  fs::create_symlink("/dev/null", maps_ + "/device.ply");
  fs::create_symlink(maps_ + "/nowhere", maps_ + "/dangling.ply");
  fs::create_directory(maps_ + "/folder.ply");
  for (const std::string name : {"fifo.ply", "link.ply", "device.ply", "dangling.ply"}) {
    expectRefused(name, "no regular file", true);
  }
  expectRefused("folder.ply", "directory", true);
}

TEST_F(SavePlaceTest, AFileThatIsThereIsReplacedOnlyWhenAsked) {
  touch(maps_ + "/a.ply");
  expectRefused("a.ply", "overwrite: true");
  EXPECT_EQ(refusal("a.ply", true), "");
}

TEST_F(SavePlaceTest, OwnFilesAreReplaced) {
  const std::string file = place().resolve("a.ply", false);
  touch(file);
  place().own(file);
  EXPECT_EQ(refusal("sub/../a.ply"), "");
}

TEST_F(SavePlaceTest, RecordingsAreLeftAlone) {
  fs::create_directories(maps_ + "/recording/tiles");
  touch(maps_ + "/recording/recording.yaml");
  expectRefused("recording/tiles/0_0_0.pcd", "is a recording", true);
  expectRefused("recording/a.ply", "is a recording");
}

TEST_F(SavePlaceTest, OddPathsAreRefused) {
  for (const std::string path : {"", ".", "..", "/", "sub", "a.e57", "no/such/a.ply"}) EXPECT_NE(refusal(path), "");
  expectRefused(std::string("a.ply\0.pcd", 10), "byte 0");
}

TEST_F(SavePlaceTest, AMissingDirectoryIsAnErrorAtTheStart) {
  EXPECT_THROW(SavePlace(scratch_.path() + "/none"), std::runtime_error);
}

}  // namespace
}  // namespace cloud_colorizer
