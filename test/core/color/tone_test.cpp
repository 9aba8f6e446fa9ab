// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/tone.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cloud_colorizer {
namespace {

/// A street along x out of the shade: gains from 1/3 at x = 0 to 3 at x = 100.
double logGainAt(double x) {
  return std::log(3) * (x / 50 - 1);
}

ToneCells street() {
  ToneCells cells;
  for (std::int32_t x = 0; x < 50; ++x) cells[{x, 0, 0}] = {10 * logGainAt(2 * x + 1), 10};
  return cells;
}

double factorAt(const ToneField& field, const Eigen::Vector3f& place) {
  Values value = Values::Constant(1, 1, 1);
  field.apply(Points(place), value);
  return static_cast<double>(value(0, 0));
}

TEST(ToneField, OfNoSamplesChangesNothing) {
  EXPECT_EQ(factorAt({}, {1, 2, 3}), 1);
  EXPECT_EQ(factorAt({{}, 2, {}}, {1, 2, 3}), 1);
  Values none(3, 0);
  ToneField(street(), 2, {}).apply(Points(3, 0), none);
}

TEST(ToneField, KeepsEveryPlaceWithinTheRangeOfWhatItsCamerasSaw) {
  const ToneField field(street(), 2, {});
  EXPECT_NEAR(factorAt(field, {50, 1, 1}), 1, 1e-6);  // its cameras and the whole map agree
  for (const double x : {10.0, 20.0, 80.0, 90.0}) {
    const double brightness = std::exp(logGainAt(x)) * factorAt(field, {static_cast<float>(x), 1, 1});
    EXPECT_NEAR(brightness, x < 50 ? 1 / 1.1 : 1.1, 0.01);
  }
}

TEST(ToneField, RangeOneFollowsTheCamerasAndAWideRangeLeavesAll) {
  ToneParams params;
  params.exposure_range = 1;
  EXPECT_NEAR(factorAt({{{{0, 0, 0}, {std::log(2), 1}}}, 2, params}, {1, 1, 1}), 0.5, 1e-6);
  params.exposure_range = 10;
  EXPECT_EQ(factorAt({street(), 2, params}, {99, 1, 1}), 1);
}

TEST(ToneField, IsSmoothAcrossCellsAndDoesNotDependOnThePointsAskedFor) {
  const ToneField field(street(), 2, {});
  Points points(3, 1001);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) << 0.1F * static_cast<float>(i), 1, -3;
  Values together = Values::Constant(3, points.cols(), 1);
  field.apply(points, together);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    EXPECT_NEAR(together(0, i), factorAt(field, points.col(i)), 1e-6);
    if (i == 0) continue;
    EXPECT_NEAR(together(0, i) / together(0, i - 1), 1, 0.01);
  }
}

TEST(ToneField, CellsLieAroundTheirIndexAlsoBelowZero) {
  EXPECT_EQ(ToneField::cellOf({-0.5F, 3.9F, 4}, 2), (ToneCell{-1, 1, 2}));
}

TEST(ToneField, BadInputIsRefused) {
  ToneParams params;
  params.exposure_range = 0.5;
  EXPECT_THROW(ToneField({}, 2, params), std::invalid_argument);
  EXPECT_THROW(ToneField({}, 0, {}), std::invalid_argument);
  EXPECT_THROW(ToneField({{{0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 1}}}, 2, {}), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
