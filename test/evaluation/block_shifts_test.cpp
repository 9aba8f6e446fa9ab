// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/block_shifts.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cloud_colorizer {
namespace {

float patternAt(float x, float y) {
  return 120 + 50 * std::sin(0.11F * x) * std::cos(0.13F * y + 1) + 20 * std::sin(0.05F * y);
}

struct Scene {
  cv::Mat3b image = cv::Mat3b(240, 320);
  ColoredMap map;
  SeenImage seen;

  /// The image shows the map's pattern so many pixels to the right and below; `contrast` 0: nothing.
  Scene(float right, float below, float contrast) {
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const float value = patternAt(static_cast<float>(x) - right, static_cast<float>(y) - below);
        image(y, x) = cv::Vec3b::all(cv::saturate_cast<uchar>(120 + 0.8F * contrast * (value - 120)));
      }
    }
    for (int y = 10; y < 230; y += 2) {
      for (int x = 10; x < 310; x += 2) {
        seen.points.push_back(static_cast<Eigen::Index>(seen.points.size()));
        seen.pixels.emplace_back(x, y);
      }
    }
    const auto count = static_cast<Eigen::Index>(seen.points.size());
    map.colored.assign(seen.points.size(), 1);
    map.colors.resize(3, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Vector2f& pixel = seen.pixels[static_cast<std::size_t>(k)];
      map.colors.col(k).setConstant(patternAt(pixel.x(), pixel.y()));
    }
  }
};

TEST(BlockShifts, FindsHowFarAnImageLiesFromTheMap) {
  const Scene scene(1.2F, -0.9F, 1);
  const std::vector<BlockShift> shifts = blockShifts(scene.map, scene.seen, scene.image);
  EXPECT_GT(shifts.size(), 20U);
  for (const BlockShift& shift : shifts) {
    EXPECT_NEAR(shift.pixels, 1.5F, 0.3F);
    EXPECT_LT(shift.error, 0.34F);
  }
}

TEST(BlockShifts, WithoutTextureNothingIsTold) {
  const Scene scene(1, 1, 0);
  EXPECT_TRUE(blockShifts(scene.map, scene.seen, scene.image).empty());
}

}  // namespace
}  // namespace cloud_colorizer
