// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/fuse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cloud_colorizer {
namespace {

/// Observations of points with the given numbers of views; view ids 0, 1, ... and distances 1, 2, ... by point.
Observations observed(const std::vector<std::uint32_t>& counts, const Values& values) {
  Observations observations;
  observations.offsets.push_back(0);
  for (const std::uint32_t count : counts) {
    observations.offsets.push_back(observations.offsets.back() + count);
    for (std::uint32_t i = 0; i < count; ++i) {
      observations.views.push_back(i);
      observations.distances.push_back(static_cast<float>(i + 1));
      observations.weights.push_back(1);
    }
  }
  observations.values = values;
  return observations;
}

Values row(const std::vector<float>& values) {
  return Eigen::Map<const Values>(values.data(), 1, static_cast<Eigen::Index>(values.size()));
}

TEST(Fuse, ClosestTakesTheSmallestDistance) {
  Observations observations = observed({3}, row({10, 20, 30}));
  observations.distances = {5, 2, 3};
  observations.weights = {1, 0.1F, 1};
  EXPECT_EQ(fuseClosest(observations).values(0, 0), 20);
}

TEST(Fuse, MeanAndMedianByChannelWithoutWeights) {
  Values values(2, 4);
  values << 1, 2, 9, 4, 40, 10, 20, 31;
  Observations observations = observed({4}, values);
  observations.weights = {0.1F, 1, 0, 0.5F};
  EXPECT_TRUE(fuseMean(observations).values.isApprox(Eigen::Vector2f(4, 25.25F)));
  EXPECT_TRUE(fuseMedian(observations).values.isApprox(Eigen::Vector2f(3, 25.5F)));
}

TEST(Fuse, StddevIsTheMeanOverTheChannels) {
  Values values(2, 3);
  values << 0, 10, 5, 0, 20, 5;
  const Fused fused = fuseMean(observed({2, 1}, values));
  EXPECT_FLOAT_EQ(fused.stddev(0), 7.5F);
  EXPECT_EQ(fused.stddev(1), 0);
}

TEST(Fuse, PointWithoutViewsIsZeroInEveryMethod) {
  const Observations observations = observed({1, 0, 2}, row({7, 8, 10}));
  for (const Fused& fused :
       {fuseClosest(observations), fuseMean(observations), fuseMedian(observations), fuseRobust(observations, 2)}) {
    EXPECT_EQ(fused.values(0, 0), 7);
    EXPECT_EQ(fused.values(0, 1), 0);
    EXPECT_EQ(fused.stddev(1), 0);
    EXPECT_EQ(fused.count, Eigen::Vector3i(1, 0, 2));
  }
}

TEST(Fuse, RobustForgetsAPasserBy) {
  const Fused fused = fuseRobust(observed({6}, row({100, 101, 99, 100, 100, 250})), 2);
  EXPECT_NEAR(fused.values(0, 0), 100, 0.05);
  EXPECT_EQ(fused.observation_weights(5), 0);
  EXPECT_GT(fused.observation_weights.head(5).minCoeff(), 0.9F);
  EXPECT_LT(fused.stddev(0), 1);
}

TEST(Fuse, RobustMeetsTheIndependentFormulaAtItsFixedPoint) {
  const std::vector<float> values = {50, 54, 46, 52, 47, 90, 51};
  const Fused fused = fuseRobust(observed({7}, row(values)), 0.5F);
  const double scale = 1.4826 * 3;  // median 51; residuals 1 3 5 1 4 39 0
  double center = 51;
  for (int round = 0; round < 50; ++round) {
    double sum = 0, total = 0;
    for (const float value : values) {
      const double ratio = (value - center) / (4.685 * scale);
      const double weight = std::abs(ratio) < 1 ? std::pow(1 - ratio * ratio, 2) : 0;
      sum += weight * value, total += weight;
    }
    center = sum / total;
  }
  EXPECT_NEAR(fused.values(0, 0), center, 0.02);
}

TEST(Fuse, RobustOfTwoViewsIsTheWeightedMean) {
  Observations observations = observed({2}, row({0, 100}));
  observations.weights = {0.25F, 0.75F};
  EXPECT_FLOAT_EQ(fuseRobust(observations, 2).values(0, 0), 75);
}

TEST(Fuse, RobustWeighsObservations) {
  Observations observations = observed({5}, row({10, 10, 10, 200, 200}));
  observations.weights = {0.1F, 0.1F, 0.1F, 1, 1};  // the majority is at depth edges
  EXPECT_NEAR(fuseRobust(observations, 2).values(0, 0), 200, 1e-3);
}

TEST(Fuse, RobustIsNeverNaN) {
  Observations observations = observed({3, 4, 1}, row({5, 5, 5, 0, 0, 255, 255, 9}));
  EXPECT_TRUE(fuseRobust(observations, 1e-6F).values.allFinite());
  observations.weights.assign(8, 0.0F);  // nothing is good: then all are equally bad
  const Fused fused = fuseRobust(observations, 1e-6F);
  EXPECT_TRUE(fused.values.allFinite());
  EXPECT_EQ(fused.values(0, 0), 5);
  EXPECT_EQ(fused.values(0, 2), 9);
}

TEST(Fuse, BadObservationsAreRefused) {
  const Observations good = observed({2, 1}, row({1, 2, 3}));
  const auto refused = [&](auto spoil) {
    Observations bad = good;
    spoil(bad);
    EXPECT_THROW(fuseMean(bad), std::invalid_argument);
  };
  refused([](auto& o) { o.distances.pop_back(); });
  refused([](auto& o) { o.weights.pop_back(); });
  refused([](auto& o) { o.values.conservativeResize(1, 2); });
  refused([](auto& o) { o.offsets.back() = 2; });
  refused([](auto& o) { o.offsets[1] = 4; });
  refused([](auto& o) { o.values(0, 1) = std::numeric_limits<float>::quiet_NaN(); });
  refused([](auto& o) { o.weights[0] = -1; });
  EXPECT_THROW(fuseRobust(good, 0), std::invalid_argument);
  EXPECT_THROW(fuseRobust(good, NAN), std::invalid_argument);
}

TEST(Fuse, NoObservationsGiveNoPoints) {
  for (const Fused& fused : {fuseClosest({}), fuseMean({}), fuseMedian({}), fuseRobust({}, 2)}) {
    EXPECT_EQ(fused.values.cols(), 0);
    EXPECT_EQ(fused.count.size(), 0);
  }
}

}  // namespace
}  // namespace cloud_colorizer
