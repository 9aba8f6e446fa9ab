// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Runs of points that follow each other in memory, each in a ball, so that a view passes over most of them at once.
/// Where points are in Z-order, or come tile by tile, the balls are small.
#pragma once

#include <algorithm>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/surfels.hpp"

namespace cloud_colorizer {

struct PointRun {
  Eigen::Index begin = 0, end = 0;
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  float radius = 0;   ///< of a ball about the center that holds the points
  float largest = 0;  ///< m, radius of a surfel
};

/// Of points that are moved onto their surfels.
inline std::vector<PointRun> makeRuns(PointsRef places, const Surfels& surfels) {
  constexpr Eigen::Index kRunLength = 64;
  std::vector<PointRun> runs;
  for (Eigen::Index begin = 0; begin < places.cols(); begin += kRunLength) {
    PointRun run{begin, std::min(begin + kRunLength, places.cols()), Eigen::Vector3f::Zero(), 0, 0};
    run.center = places.middleCols(run.begin, run.end - run.begin).rowwise().mean();
    for (Eigen::Index i = run.begin; i < run.end; ++i) {
      run.radius = std::max(run.radius, (places.col(i) - run.center).norm());
      run.largest = std::max(run.largest, std::abs(surfels.radii[i]));
    }
    runs.push_back(run);
  }
  return runs;
}

}  // namespace cloud_colorizer
