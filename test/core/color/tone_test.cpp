// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/tone.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cloud_colorizer {
namespace {

constexpr double kCell = 2;    // m
constexpr int kViews = 100;    // one a metre along x
constexpr double kReach = 10;  // m before and behind it that a view shows

/// A street of 100 m along x with a point a metre, none brighter than `peak`.
ToneCells street(double peak = 100) {
  ToneCells cells;
  for (int x = 0; x < kViews; ++x) {
    ToneSum& cell = cells[{x / 2, 0, 0}];
    cell.peak = peak;
    for (int view = 0; view < kViews; ++view) {
      if (std::abs(view - x) <= kReach) cell.views[static_cast<std::uint32_t>(view)] += 1 / (2 * kReach);
    }
  }
  return cells;
}
std::vector<float> logGains(double (*at)(double)) {
  std::vector<float> gains;
  for (int view = 0; view < kViews; ++view) gains.push_back(static_cast<float>(at(view)));
  return gains;
}
/// Out of the shade, gains from 1/2 to 2.
double slowly(double x) {
  return std::log(2) * (x / 50 - 1);
}
double atOnce(double x) {
  return x < 50 ? -std::log(2) : std::log(2);
}

double factorAt(const ToneField& field, double x, float radiance = 1) {
  return static_cast<double>(
      field.factors(Points(Eigen::Vector3f(static_cast<float>(x), 1, 1)), Values::Constant(3, 1, radiance))[0]);
}

TEST(ToneField, OfNothingChangesNothing) {
  EXPECT_EQ(factorAt({}, 1), 1);
  EXPECT_EQ(factorAt({{}, {}, kCell, Tone::kDisplay}, 1), 1);
  EXPECT_EQ(ToneField(street(), logGains(slowly), kCell, Tone::kDisplay).factors(Points(3, 0), Values(3, 0)).size(), 0);
}

TEST(ToneField, WhereExposuresChangeSlowlyEveryPlaceIsAsBrightAsItsCamerasSawIt) {
  const ToneField field(street(), logGains(slowly), kCell, Tone::kDisplay);
  for (const double x : {20.0, 35.0, 50.0, 65.0, 80.0}) EXPECT_NEAR(factorAt(field, x) * std::exp(slowly(x)), 1, 0.03);
}

TEST(ToneField, WhereTheExposureJumpsBrightnessChangesOverTheReachOfAView) {
  const ToneField field(street(), logGains(atOnce), kCell, Tone::kDisplay);
  EXPECT_NEAR(factorAt(field, 49.5), 1, 0.05);
  EXPECT_NEAR(factorAt(field, 15), 2, 0.1);
  EXPECT_NEAR(factorAt(field, 85), 0.5, 0.03);
  double steepest = 0;
  for (double x = 1.5; x < 99; x += 0.5) {
    steepest = std::max(steepest, std::abs(std::log(factorAt(field, x) / factorAt(field, x - 0.5))) / 0.5);
  }
  EXPECT_LT(steepest, std::log(4) / (2 * kReach));
}

TEST(ToneField, OfOneRoomSeenByAllViewsTheWholeHasOneFactor) {
  ToneCells room;
  for (std::int32_t x = 0; x < 10; ++x) room[{x, 0, 0}] = {{{0, 1}, {1, 1}}, 100};
  const ToneField field(room, {std::log(2.F), -std::log(2.F)}, kCell, Tone::kDisplay);
  for (const double x : {1.0, 9.0, 19.0}) EXPECT_NEAR(factorAt(field, x), 1, 1e-6);
}

TEST(ToneField, RadianceFollowsNoExposure) {
  const ToneField field(street(), logGains(slowly), kCell, Tone::kRadiance);
  for (const double x : {1.0, 50.0, 99.0}) EXPECT_EQ(factorAt(field, x, 100), 1);
}

TEST(ToneField, HighlightsAreCompressedNotCutOff) {
  const ToneField field(street(1000), logGains(slowly), kCell, Tone::kRadiance);
  double last = 0;
  for (double radiance = 10; radiance <= 1000; radiance += 10) {
    const double shown = radiance * factorAt(field, 50, static_cast<float>(radiance));
    EXPECT_GT(shown, last);
    if (radiance <= 200) {
      EXPECT_NEAR(shown, radiance, 1e-3);
    }
    last = shown;
  }
  EXPECT_NEAR(last, 255, 0.1);
}

TEST(ToneField, WhatEightBitsHoldIsLeftAsItIs) {
  const ToneField field(street(255), logGains(slowly), kCell, Tone::kRadiance);
  EXPECT_EQ(factorAt(field, 50, 255), 1);
}

TEST(ToneField, IsSmoothAcrossCellsAndDoesNotDependOnThePointsAskedFor) {
  const ToneField field(street(), logGains(slowly), kCell, Tone::kDisplay);
  Points points(3, 1001);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) << 0.1F * static_cast<float>(i), 1, 1;
  const Eigen::RowVectorXf together = field.factors(points, Values::Ones(3, points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    EXPECT_NEAR(static_cast<double>(together[i]), factorAt(field, static_cast<double>(points(0, i))), 1e-6);
    if (i > 0) {
      EXPECT_NEAR(together[i] / together[i - 1], 1, 0.01);
    }
  }
}

TEST(ToneField, BadInputIsRefused) {
  EXPECT_THROW(ToneField({}, {}, 0, Tone::kDisplay), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ToneField({{{0, 0, 0}, {{{0, 1}}, nan}}}, {0}, 2, Tone::kDisplay), std::invalid_argument);
  EXPECT_THROW(ToneField({{{0, 0, 0}, {{{1, 1}}, 9}}}, {0}, 2, Tone::kDisplay), std::invalid_argument);
}

TEST(CountViews, PointsAreSharedAmongTheirViewsInCellsAroundTheirIndexAlsoBelowZero) {
  Points points(3, 3);
  points << -0.5F, -0.1F, 5, 3.9F, 3.9F, 5, 4, 4, 5;
  Observations seen;
  seen.offsets = {0, 2, 3, 3};
  seen.views = {0, 2, 2};
  seen.weights = {0.1F, 0.3F, 0.2F};
  ToneCells cells = countViews(points, {0, 1, 2}, seen, kCell);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells.begin()->first, (ToneCell{-1, 1, 2}));
  const auto& views = cells.begin()->second.views;
  ASSERT_EQ(views.size(), 2U);
  EXPECT_NEAR(views.at(0), 0.25, 1e-6);
  EXPECT_NEAR(views.at(2), 1.75, 1e-6);

  ToneCells twice = cells;
  addCells(cells, twice);
  EXPECT_NEAR(twice.begin()->second.views.at(2), 3.5, 1e-6);
}

TEST(AddPeaks, OneInAThousandMayBeBrighter) {
  ToneCells cells = {{{0, 0, 0}, {{{0, 1}}, 0}}};
  Values radiance = Values::Constant(3, 2001, 90);
  radiance(0, 7) = 5000;
  addPeaks(Points::Zero(3, 2001), radiance, kCell, cells);
  EXPECT_EQ(cells.begin()->second.peak, 90);
  addPeaks(Points::Zero(3, 1), Values::Constant(3, 1, 300), kCell, cells);
  EXPECT_EQ(cells.begin()->second.peak, 300);
}

}  // namespace
}  // namespace cloud_colorizer
