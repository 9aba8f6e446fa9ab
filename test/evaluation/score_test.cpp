// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/score.hpp"

#include <gtest/gtest.h>

#include "evaluation/neighbors.hpp"

namespace cloud_colorizer {
namespace {

TEST(Ciede2000, MatchesThePublishedTestPairs) {
  // Sharma, Wu, Dalal 2005, table 1.
  const double pairs[][7] = {
      {50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425},
      {50, 3.1571, -77.2803, 50, 0, -82.7485, 2.8615},
      {50, 2.8361, -74.0200, 50, 0, -82.7485, 3.4412},
      {50, -1.3802, -84.2814, 50, 0, -82.7485, 1.0000},
      {50, 0, 0, 50, -1, 2, 2.3669},
      {50, 2.49, -0.001, 50, -2.49, 0.0009, 7.1792},
      {50, 2.49, -0.001, 50, -2.49, 0.0011, 7.2195},
      {50, -0.001, 2.49, 50, 0.0009, -2.49, 4.8045},
      {50, -0.001, 2.49, 50, 0.0011, -2.49, 4.7461},
      {50, 2.5, 0, 50, 0, -2.5, 4.3065},
      {50, 2.5, 0, 73, 25, -18, 27.1492},
      {50, 2.5, 0, 61, -5, 29, 22.8977},
      {50, 2.5, 0, 56, -27, -3, 31.9030},
      {50, 2.5, 0, 58, 24, 15, 19.4535},
      {50, 2.5, 0, 50, 3.2972, 0, 1.0000},
      {60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644},
      {63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630},
      {61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731},
      {35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645},
      {22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373},
      {36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146},
      {90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441},
      {90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381},
      {6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377},
      {2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082},
  };
  for (const auto& p : pairs) {
    const Eigen::Vector3d a(p[0], p[1], p[2]), b(p[3], p[4], p[5]);
    EXPECT_NEAR(ciede2000(a, b), p[6], 5e-5) << a.transpose() << " | " << b.transpose();
    EXPECT_NEAR(ciede2000(b, a), p[6], 5e-5);
  }
}

TEST(Lab, WhiteBlackAndRedAreWhereTheyBelong) {
  EXPECT_LT((labFromRgb({255, 255, 255}) - Eigen::Vector3d(100, 0, 0)).norm(), 0.02);
  EXPECT_LT(labFromRgb({0, 0, 0}).norm(), 1e-9);
  EXPECT_LT((labFromRgb({255, 0, 0}) - Eigen::Vector3d(53.24, 80.09, 67.20)).norm(), 0.02);
}

TEST(Score, KnownErrorsGiveKnownScores) {
  Values truth = Values::Constant(3, 4, 100), result = truth;
  result.col(0) << 130, 100, 100;  // mean error 10: below the threshold of REP
  result.col(1) << 130, 130, 130;  // 30: above
  result.col(2).setConstant(0);    // not coloured
  const Score score = scoreColors(truth, result, {1, 1, 0, 1});
  EXPECT_EQ(score.num_points, 3U);
  EXPECT_DOUBLE_EQ(score.coverage, 0.75);
  EXPECT_NEAR(score.aep, 40.0 / 3, 1e-6);
  EXPECT_NEAR(score.rep, 1.0 / 3, 1e-9);
  EXPECT_NEAR(score.psnr, 10 * std::log10(255 * 255 / (4 * 900 / 9.0)), 1e-6);
  EXPECT_EQ(scoreColors(truth, truth, {1, 1, 1, 1}).psnr, 99);
}

TEST(Score, CommonGainIsTakenOutByChannel) {
  Values truth(3, 50);
  for (Eigen::Index p = 0; p < 50; ++p) truth.col(p).setConstant(40 + 2 * static_cast<float>(p));
  Values result = truth;
  result.row(0) /= 1.25F;
  result.row(2) /= 0.9F;
  result.col(7).setConstant(200);  // an outlier moves a weighted median little
  const Score score = scoreColors(truth, result, std::vector<std::uint8_t>(50, 1));
  EXPECT_NEAR(score.gain[0], 1.25, 1e-3);
  EXPECT_NEAR(score.gain[1], 1, 1e-3);
  EXPECT_NEAR(score.gain[2], 0.9, 1e-3);
  EXPECT_GT(score.aep, 5);
  EXPECT_LT(score.aep_gain, 4);
}

TEST(Score, ValuesBeyondTheRangeOfAColourAreClamped) {
  const Values truth = Values::Constant(3, 1, 250), result = Values::Constant(3, 1, 400);
  EXPECT_NEAR(scoreColors(truth, result, {1}).aep, 5, 1e-6);
}

TEST(Score, NothingColouredIsAnError) {
  const Values values = Values::Zero(3, 2);
  EXPECT_THROW(scoreColors(values, values, {0, 0}), std::invalid_argument);
  EXPECT_THROW(scoreColors(values, Values::Zero(3, 3), {1, 1}), std::invalid_argument);
}

TEST(Score, CloudsAreComparedAtTheNearestPoint) {
  Points truth_points(3, 3), points(3, 2);
  truth_points << 0, 1, 9, 0, 0, 0, 0, 0, 0;
  points << 1.01F, 0.02F, 0, 0, 0, 0;
  Values truth(3, 3), result(3, 2);
  truth.colwise() = Eigen::Vector3f(10, 10, 10);
  truth.col(1).setConstant(50);
  result.col(0).setConstant(53);
  result.col(1).setConstant(10);
  const Score score = scoreClouds(truth_points, truth, points, result, 0.1);
  EXPECT_NEAR(score.coverage, 2.0 / 3, 1e-9);
  EXPECT_NEAR(score.aep, 1.5, 1e-6);
}

TEST(Score, CloudsThatDoNotOverlapAreRefusedWithTheDistance) {
  const Points here = Points::Zero(3, 1), there = Points::Constant(3, 1, 100);
  const Values color = Values::Zero(3, 1);
  try {
    scoreClouds(here, color, there, color, 0.5);
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("do not overlap"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("173.2"), std::string::npos);
  }
  EXPECT_THROW(scoreClouds(here, color, Points(3, 0), Values(3, 0), 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
