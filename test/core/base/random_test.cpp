// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/random.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer {
namespace {

TEST(Random, MixedBitsAreThoseOfSplitmix64) {
  // The first two outputs of the published generator from the seed 0.
  EXPECT_EQ(mixBits(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(mixBits(0x9e3779b97f4a7c15ULL), 0x6e789e6aa1b965f4ULL);
}

TEST(Random, QuantilesAreThoseOfTheStandardNormal) {
  const std::vector<float> two = normalQuantiles(2), many = normalQuantiles(1000);
  EXPECT_NEAR(two[0], -0.67449F, 1e-5F);
  EXPECT_NEAR(two[1], 0.67449F, 1e-5F);
  EXPECT_NEAR(many[974] / 2 + many[975] / 2, 1.95996F, 1e-3F);
  EXPECT_TRUE(normalQuantiles(0).empty());
}

TEST(Random, GaussianOfUniformNumbers) {
  double sum = 0, squares = 0;
  constexpr int kCount = 20000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const auto uniform = [](std::uint64_t bits) { return (static_cast<double>(bits >> 11U) + 0.5) * 0x1p-53; };
    const double value = gaussianOf(uniform(mixBits(2 * i)), uniform(mixBits(2 * i + 1)));
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.03);
  EXPECT_NEAR(squares / kCount, 1, 0.03);
}

}  // namespace
}  // namespace cloud_colorizer
