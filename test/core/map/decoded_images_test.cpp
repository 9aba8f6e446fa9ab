// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/decoded_images.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kBytes = 3 * 20 * 10;  // of one image

class DecodedImagesTest : public ::testing::Test {
 protected:
  DecodedImagesTest() : recording_(record()) {}

  Recording record() {
    Recorder recorder(scratch_ / "r", "map", RecordParams());
    const auto camera = recorder.setCamera("camera_0", {20, 10, 8, 8, 4, 4, DistortionModel::kPlumbBob, {}});
    for (int i = 0; i < 4; ++i) {
      cv::Mat3b bgr(10, 20);
      cv::randu(bgr, 0, 255);
      std::vector<std::uint8_t> png;
      cv::imencode(".png", bgr, png);
      cv::Mat1b mask;
      if (i == 2) mask = cv::Mat1b(10, 20, std::uint8_t{255});
      if (i == 2) mask(3, 4) = 0;
      recorder.addView(camera, i, Eigen::Isometry3d::Identity(), png, "png", mask);
    }
    return recorder.snapshot();
  }
  bool hasFolder() const { return std::filesystem::exists(recording_.directory() + "/decoded"); }
  void expectAllRight(DecodedImages& images) const {
    for (std::size_t round = 0; round < 3; ++round) {
      for (std::size_t view = 0; view < 4; ++view) {
        const ViewPixels expected = recording_.readPixels(view);
        const auto pixels = images.get(view);
        EXPECT_EQ(cv::norm(pixels->image, expected.image, cv::NORM_INF), 0);
        ASSERT_EQ(pixels->mask.size(), expected.mask.size());
        EXPECT_TRUE(expected.mask.empty() || cv::norm(pixels->mask, expected.mask, cv::NORM_INF) == 0);
      }
    }
  }

  ScratchDirectory scratch_;
  Recording recording_;
};

TEST_F(DecodedImagesTest, WhatFitsInMemoryNeedsNoFolder) {
  DecodedImages images(recording_, 4 * kBytes, "v", true);
  expectAllRight(images);
  EXPECT_FALSE(hasFolder());
}

TEST_F(DecodedImagesTest, WhatDoesNotFitIsDecodedOnceAndItsFolderRemoved) {
  {
    DecodedImages images(recording_, kBytes, "v", true);
    expectAllRight(images);
    EXPECT_TRUE(hasFolder());
    const auto kept = images.get(0);
    for (std::size_t view = 0; view < 4; ++view) {
      std::filesystem::remove(recording_.directory() + '/' + recording_.views()[view].image);
      EXPECT_EQ(images.get(view)->image.size(), cv::Size(20, 10));
    }
    EXPECT_EQ(cv::norm(kept->image, images.get(0)->image, cv::NORM_INF),
              0);  // also what has left the cache stays valid
  }
  EXPECT_FALSE(hasFolder());
}

TEST_F(DecodedImagesTest, PixelsOfARunThatWasKilledAreNotUsed) {
  std::filesystem::create_directories(recording_.directory() + "/decoded/v");
  writeText(recording_.directory() + "/decoded/v/000000", std::string(kBytes, 'x'));
  DecodedImages images(recording_, kBytes, "v", true);
  expectAllRight(images);
}

TEST_F(DecodedImagesTest, ProgramsShareThePixelsOfTheSameImagesAndLeaveThem) {
  {
    DecodedImages one(recording_, kBytes, "v", false), other(recording_, kBytes, "v", false);
    expectAllRight(one);
    std::filesystem::remove(recording_.directory() + '/' + recording_.views()[0].image);
    EXPECT_EQ(other.get(0)->image.size(), cv::Size(20, 10));
    DecodedImages changed(recording_, kBytes, "v2", false);
    EXPECT_THROW(changed.get(0), std::runtime_error);
  }
  EXPECT_TRUE(hasFolder());
}

}  // namespace
}  // namespace cloud_colorizer
