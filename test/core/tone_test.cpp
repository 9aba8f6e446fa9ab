// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/tone.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cloud_colorizer {
namespace {

/// A drive along x out of the shade: gains from 1/3 to 3.
std::vector<ViewTone> drive() {
  std::vector<ViewTone> views;
  for (int i = 0; i <= 100; ++i) {
    views.push_back({{static_cast<float>(i), 0, 0}, std::pow(3.0F, static_cast<float>(i) / 50 - 1)});
  }
  return views;
}

TEST(ToneField, OfNoViewsOrEqualOnesChangesNothing) {
  Values values = Values::Constant(3, 1, 100);
  const Points point = Eigen::Vector3f(1, 2, 3);
  const Eigen::AlignedBox3f box(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(5, 5, 5));
  ToneField({}, 10, {}).apply(box, point, values);
  EXPECT_EQ(values, Values::Constant(3, 1, 100));
  EXPECT_EQ(ToneField({}, 10, {}).factorAt({0, 0, 0}), 1);
  ToneField({{{0, 0, 0}, 1.08F}, {{5, 0, 0}, 0.95F}}, 10, {}).apply(box, point, values);
  EXPECT_EQ(values, Values::Constant(3, 1, 100));
  ToneField(drive(), 10, {}).apply(box, Points(3, 0), values);
}

TEST(ToneField, KeepsEveryPlaceWithinTheRangeOfWhatItsCamerasSaw) {
  const ToneField field(drive(), 5, {});
  EXPECT_NEAR(field.factorAt({50, 0, 0}), 1, 1e-6);  // its cameras and the whole map agree
  const float shade = field.factorAt({10, 0, 0}), sun = field.factorAt({90, 0, 0});
  EXPECT_NEAR(shade * sun, 1, 1e-3);
  const float gain = std::pow(3.0F, 10.0F / 50 - 1);  // the views there were made so much darker
  EXPECT_GT(shade * gain, 1 / 1.3);
  EXPECT_LT(shade * gain, 1);
}

TEST(ToneField, RangeOneFollowsTheCamerasAndAWideRangeLeavesAll) {
  ToneParams params;
  params.exposure_range = 1;
  EXPECT_NEAR(ToneField({{{0, 0, 0}, 2}}, 5, params).factorAt({3, 0, 0}), 0.5, 1e-6);
  params.exposure_range = 10;
  EXPECT_EQ(ToneField(drive(), 5, params).factorAt({100, 0, 0}), 1);
}

TEST(ToneField, BoxesThatShareASideAgreeOnIt) {
  const ToneField field(drive(), 5, {});
  const Eigen::AlignedBox3f left(Eigen::Vector3f(70, -5, -5), Eigen::Vector3f(80, 5, 5));
  const Eigen::AlignedBox3f right(Eigen::Vector3f(80, -5, -5), Eigen::Vector3f(90, 5, 5));
  const Points side = Eigen::Vector3f(80, 1, -2);
  Values a = Values::Constant(3, 1, 100), b = a;
  field.apply(left, side, a);
  field.apply(right, side, b);
  EXPECT_TRUE(a.isApprox(b, 1e-5F));
  EXPECT_NEAR(a(0, 0), 100 * field.factorAt(side.col(0)), 2);  // trilinear is near the truth
  EXPECT_LT(a(0, 0), 80);
}

TEST(ToneField, BadParametersAreRefused) {
  ToneParams params;
  params.exposure_range = 0.5;
  EXPECT_THROW(ToneField({}, 5, params), std::invalid_argument);
  EXPECT_THROW(ToneField({}, 0, {}), std::invalid_argument);
  EXPECT_THROW(ToneField({{{0, 0, 0}, 0}}, 5, {}), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
