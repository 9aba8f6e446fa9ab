// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/quantity.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cloud_colorizer {
namespace {

/// `counts`: views of each point; one column of values for each observation.
Observations observed(const std::vector<std::uint32_t>& counts, const Values& values) {
  Observations observations;
  observations.offsets.push_back(0);
  for (const std::uint32_t count : counts) {
    observations.offsets.push_back(observations.offsets.back() + count);
    for (std::uint32_t i = 0; i < count; ++i) observations.views.push_back(i);
  }
  observations.distances.assign(observations.views.size(), 1);
  observations.weights.assign(observations.views.size(), 1);
  observations.values = values;
  return observations;
}

Values fused(const Observations& observations, ImageKind kind, Method method = Method::kMean) {
  Points points = Points::Zero(3, static_cast<Eigen::Index>(observations.numPoints()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) points(0, i) = 0.1F * static_cast<float>(i);
  return fuseQuantity(points, observations, {}, kind, method, {}, {});
}

TEST(Quantity, TheClassWithTheGreatestWeightWins) {
  Values values(1, 6);
  values << 7, 3, 3, 9, 4, 2;
  Observations observations = observed({3, 0, 1, 2}, values);
  observations.weights = {0.9F, 0.4F, 0.6F, 0, 0.5F, 0.5F};
  const Values fields = fused(observations, ImageKind::kLabels);
  EXPECT_EQ(fields(0, 0), 3);
  EXPECT_NEAR(fields(1, 0), 1 / 1.9, 1e-6);
  EXPECT_EQ(fields.col(1), Eigen::Vector2f(0, 0));     // no view
  EXPECT_EQ(fields.col(2), Eigen::Vector2f(9, 1));     // the only view, though it hardly counts
  EXPECT_EQ(fields.col(3), Eigen::Vector2f(2, 0.5F));  // a tie: the smaller number
}

TEST(Quantity, LogarithmsOfProbabilitiesAddUp) {
  Values scores(3, 2);
  scores.col(0) << std::log(0.5F), std::log(0.3F), std::log(0.2F);
  scores.col(1) << std::log(0.1F) + 5, std::log(0.6F) + 5, std::log(0.3F) + 5;  // a constant says nothing
  const Values fields = fused(observed({2}, scores), ImageKind::kLogits);
  EXPECT_EQ(fields(0, 0), 1);
  EXPECT_NEAR(fields(1, 0), 0.18 / (0.05 + 0.18 + 0.06), 1e-5);
}

TEST(Quantity, MeasuredValuesAreFusedInAnyUnit) {
  Values celsius(1, 8);
  celsius << 20, 22, 24, 21, 23, 19, 25, 18;
  for (const Method method : {Method::kMean, Method::kDefault}) {
    const Values warm = fused(observed({2, 3, 0, 3}, celsius), ImageKind::kRadiometric, method);
    const Values kelvin =
        fused(observed({2, 3, 0, 3}, (celsius.array() + 273.15F).matrix()), ImageKind::kRadiometric, method);
    EXPECT_NEAR(warm(0, 0), 21, method == Method::kMean ? 1e-4 : 1);
    EXPECT_EQ(warm(1, 1), 3);
    EXPECT_EQ(warm.col(2), Eigen::Vector2f(0, 0));
    for (const Eigen::Index p : {0, 1, 3}) EXPECT_NEAR(kelvin(0, p) - 273.15F, warm(0, p), 1e-3);
  }
  const Values same = fused(observed({2}, Values::Constant(1, 2, 5.F)), ImageKind::kRadiometric);
  EXPECT_EQ(same(0, 0), 5);
}

TEST(Quantity, FieldsAreNamedAfterIt) {
  const std::vector<Field> of_value = fieldsOf({ImageKind::kRadiometric, "temperature", 1, 0, ""});
  EXPECT_EQ(of_value[0].name, "temperature");
  EXPECT_EQ(of_value[1].name, "temperature_views");
  EXPECT_EQ(fieldsOf({ImageKind::kLabels, "label", 1, 0, ""})[1].name, "label_confidence");
  EXPECT_THROW((Quantity{ImageKind::kLabels, "a b", 1, 0, ""}).check(), std::invalid_argument);
  EXPECT_THROW((Quantity{ImageKind::kRadiometric, "t", 0, 0, ""}).check(), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
