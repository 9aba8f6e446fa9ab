// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/appearance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Eigen::Vector3f;

const Vector3f kLight = Vector3f(0.3F, -0.5F, 0.8F).normalized();

/// A plate of 2 m with texture, seen by a row of views; its right half shines.
struct Plate {
  Points points;
  Eigen::Matrix3Xf normals;
  std::vector<Vector3f> eyes;
  Observations observations;
  Eigen::Matrix3Xf colors;  ///< without sheen

  explicit Plate(float sheen, float exponent = 20) {
    constexpr int kSide = 80, kViews = 12;
    for (int i = 0; i < kViews; ++i) eyes.emplace_back(-3.F + 0.5F * static_cast<float>(i), 2, 2.5F);
    points.resize(3, kSide * kSide);
    colors.resize(3, points.cols());
    std::vector<float> values;
    observations.offsets.push_back(0);
    for (Index p = 0; p < points.cols(); ++p) {
      const float x = -1 + 2 * static_cast<float>(p % kSide) / kSide,
                  y = -1 + 2 * static_cast<float>(p / kSide) / kSide;
      points(0, p) = x, points(1, p) = y, points(2, p) = 0;
      for (Index c = 0; c < 3; ++c) colors(c, p) = 100 + 40 * std::sin(9 * x + static_cast<float>(c)) * std::cos(7 * y);
      for (std::uint32_t view = 0; view < kViews; ++view) {
        const Vector3f at(x, y, 0);
        const Vector3f h = ((eyes[view] - at).normalized() + kLight).normalized();
        const float added = x > 0 ? sheen * std::pow(h.z(), exponent) : 0;
        for (Index c = 0; c < 3; ++c) {
          const double noise = static_cast<double>(mixBits(values.size())) * 0x1p-64 - 0.5;
          values.push_back(colors(c, p) + added + 4 * static_cast<float>(noise));
        }
        observations.views.push_back(view);
        observations.distances.push_back((eyes[view] - at).norm());
        observations.weights.push_back(1);
      }
      observations.offsets.push_back(static_cast<std::uint32_t>(observations.views.size()));
    }
    normals = Vector3f(0, 0, -1).replicate(1, points.cols());  // the sign is arbitrary
    observations.values = Eigen::Map<const Values>(values.data(), 3, static_cast<Index>(values.size() / 3));
  }

  Sheen takeOut(Appearance appearance) {
    const Sights sights{points, normals, observations, eyes};
    return takeOutSheen(sights, appearance, 0.4F, observations);
  }

  /// Root mean square of the values from the mean of their point, for x > 0 or not.
  float spread(bool shines) const {
    double sum = 0, count = 0;
    for (Index p = 0; p < points.cols(); ++p) {
      if ((points(0, p) > 0.05F) != shines) continue;
      const auto own = observations.values.middleCols(observations.offsets[static_cast<std::size_t>(p)], 12);
      sum += static_cast<double>((own.colwise() - own.rowwise().mean()).squaredNorm());
      count += 36;
    }
    return static_cast<float>(std::sqrt(sum / count));
  }
};

TEST(Appearance, SheenIsTakenOutWhereItIs) {
  for (const Appearance appearance : {Appearance::kSh1, Appearance::kSh2}) {
    Plate plate(120);
    const float before = plate.spread(true), matte = plate.spread(false);
    const Values seen = plate.observations.values;
    const Sheen sheen = plate.takeOut(appearance);
    EXPECT_LT(plate.spread(true), 0.2F * before);
    EXPECT_LT(plate.spread(false), 1.05F * matte);
    double error = 0, error_of_means = 0;
    for (Index p = 0; p < plate.points.cols(); ++p) {
      if (plate.points(0, p) < 0.2F) continue;
      const Vector3f mean = plate.observations.values.middleCols(12 * p, 12).rowwise().mean();
      EXPECT_LE(sheen.least.col(p).sum(), sheen.most.col(p).sum());
      error += static_cast<double>((mean + sheen.least.col(p) - plate.colors.col(p)).cwiseAbs().mean());
      const Vector3f plain = seen.middleCols(12 * p, 12).rowwise().mean();
      error_of_means += static_cast<double>((plain - plate.colors.col(p)).cwiseAbs().mean());
    }
    EXPECT_LT(error, 0.3 * error_of_means);
  }
}

TEST(Appearance, WithoutProofNothingChanges) {
  Plate matte(0);
  const Values before = matte.observations.values;
  const Sheen sheen = matte.takeOut(Appearance::kSh2);
  EXPECT_EQ(matte.observations.values, before);
  EXPECT_TRUE(sheen.mean.isZero(0) && sheen.least.isZero(0) && sheen.most.isZero(0));
  Plate shining(120);
  const Values shown = shining.observations.values;
  EXPECT_TRUE(shining.takeOut(Appearance::kNone).mean.isZero(0));
  EXPECT_EQ(shining.observations.values, shown);
}

TEST(Appearance, TheLightIsFound) {
  const Plate plate(120, 60);
  const Light light = findLight({plate.points, plate.normals, plate.observations, plate.eyes});
  EXPECT_GT(light.direction.dot(kLight), std::cos(0.15F));
  EXPECT_NEAR(light.sharpness, 60, 30);
}

TEST(Appearance, PointsWithoutNormalOrViewsAreLeftAlone) {
  Plate plate(120);
  plate.normals.leftCols(400).setZero();
  const Values before = plate.observations.values;
  plate.takeOut(Appearance::kSh1);
  EXPECT_EQ(plate.observations.values.leftCols(12 * 400), before.leftCols(12 * 400));
  EXPECT_TRUE(plate.observations.values.allFinite());
  Observations none;
  none.offsets.assign(static_cast<std::size_t>(plate.points.cols()) + 1, 0);
  none.values.resize(3, 0);
  const Sights sights{plate.points, plate.normals, none, plate.eyes};
  EXPECT_TRUE(takeOutSheen(sights, Appearance::kSh1, 0.4F, none).mean.isZero(0));
}

}  // namespace
}  // namespace cloud_colorizer
