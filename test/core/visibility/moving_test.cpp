// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/moving.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace cloud_colorizer {
namespace {

/// A scan that measured one range in every direction.
PlacedScan sphere(double range) {
  const cv::Mat1w panorama(229, 720, static_cast<std::uint16_t>(256 * range));
  return {std::make_shared<const ScanRanges>(scanRanges(panorama)), Eigen::Isometry3f::Identity()};
}

/// Points along x.
Points pointsAt(const std::vector<float>& xs) {
  Points points = Points::Zero(3, static_cast<Eigen::Index>(xs.size()));
  for (std::size_t i = 0; i < xs.size(); ++i) points(0, static_cast<Eigen::Index>(i)) = xs[i];
  return points;
}

TEST(PlacedScan, TellsWhatLiesBeforeAtAndBehindAReturn) {
  const PlacedScan scan = sphere(10);
  EXPECT_EQ(scan.at({9, 0, 0}), ScanEvidence::kEmpty);
  EXPECT_EQ(scan.at({9.8F, 0, 0}), ScanEvidence::kSurface);
  EXPECT_EQ(scan.at({10.2F, 0, 0}), ScanEvidence::kSurface);
  EXPECT_EQ(scan.at({11, 0, 0}), ScanEvidence::kBehind);
  const PlacedScan nothing = sphere(0);
  EXPECT_EQ(nothing.at({9, 0, 0}), ScanEvidence::kNothing);
}

TEST(MovingVotes, WhatMoreScansSawThroughThanEndedAtMoved) {
  const Points points = pointsAt({5, 20});
  MovingVotes votes(2);
  votes.add(sphere(5), points);  // the van passes
  votes.add(sphere(20), points);
  votes.add(sphere(20), points);
  const auto shares = votes.shares();
  EXPECT_EQ(shares[0], 170);  // two of three
  EXPECT_EQ(shares[1], 0);
}

TEST(MovingVotes, OneScanMayErrAndATieIsNoProof) {
  const Points points = pointsAt({5});
  MovingVotes once(1), tie(1);
  once.add(sphere(20), points);
  EXPECT_EQ(once.shares()[0], 0);
  for (int i = 0; i < 2; ++i) {
    tie.add(sphere(5), points);
    tie.add(sphere(20), points);
  }
  EXPECT_LT(tie.shares()[0], kMovingShare);
}

}  // namespace
}  // namespace cloud_colorizer
