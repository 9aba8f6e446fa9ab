// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/city.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer::simulation {
namespace {

constexpr std::size_t kPoints = 20000;

CityOptions smallCity() {
  CityOptions options;
  options.points = kPoints;
  options.views = 6;
  options.width = 60, options.height = 40;
  return options;
}

Cloud scanAll(int num_threads) {
  const Drive drive(driveOfCity(smallCity()));
  StreetOptions street = streetOf(drive.options());
  street.lighting.shadow_cell = 0.5;
  const Scene scene = makeStreet(street);
  CityScanner scanner(scene, drive, viewsOfCity(drive, smallCity().views), kPoints, num_threads);
  Cloud all{Eigen::Matrix3Xd(3, 0), CityScanner::fields(), {}};
  for (Cloud cloud = scanner.next(); cloud.positions.cols() > 0; cloud = scanner.next()) {
    Eigen::Matrix3Xd joined(3, all.positions.cols() + cloud.positions.cols());
    joined << all.positions, cloud.positions;
    all.positions = joined;
    all.records.insert(all.records.end(), cloud.records.begin(), cloud.records.end());
  }
  return all;
}

TEST(City, HasAsManyPointsAsWereAskedForWithAnyNumberOfThreads) {
  const Cloud one = scanAll(1), three = scanAll(3);
  EXPECT_EQ(one.positions.cols(), static_cast<Eigen::Index>(kPoints));
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.records, three.records);
}

TEST(City, PointsLieOnTheStreetAndKnowWhoSeesThem) {
  const Cloud cloud = scanAll(0);
  const Drive drive(driveOfCity(smallCity()));
  const Scene scene = makeStreet(streetOf(drive.options()));
  const std::size_t size = recordSize(cloud.fields), seen = findField(cloud.fields, "seen")->offset;
  std::vector<TrueView> views;
  for (int camera = 0; camera < 2; ++camera) {
    for (int frame = 0; frame < drive.options().frames; ++frame) views.push_back(trueView(drive, camera, frame));
  }
  const auto truths = trueVisibility(scene, cloud.positions.leftCols(2000), views, {});
  int agree = 0, count = 0;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    ASSERT_NE(truths[i].truth, Truth::kNoSurface);
    EXPECT_LT(truths[i].surface_distance, 0.02F);
    if (truths[i].is_near_edge) continue;
    ++count;
    agree += (truths[i].truth == Truth::kVisible) == (cloud.records[i * size + seen] == 1) ? 1 : 0;
  }
  EXPECT_GT(agree, 0.99 * count);
}

TEST(City, RefusesWhatCannotBe) {
  CityOptions options = smallCity();
  options.views = 1;
  EXPECT_THROW(driveOfCity(options), std::invalid_argument);
  options = smallCity();
  options.points = 0;
  EXPECT_THROW(driveOfCity(options), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer::simulation
