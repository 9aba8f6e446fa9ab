// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/held_out.hpp"

#include <algorithm>
#include <cmath>

#include "base/position_hash.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kHeldOutShare = 1.0 / 16;  // of the points
constexpr std::uint32_t kLeastViews = 3;

std::uint8_t cellAt(const Eigen::Vector2f& place) {
  const int column = std::clamp(static_cast<int>(place.x() * kHeldOutColumns), 0, kHeldOutColumns - 1);
  const int row = std::clamp(static_cast<int>(place.y() * kHeldOutRows), 0, kHeldOutRows - 1);
  return static_cast<std::uint8_t>(row * kHeldOutColumns + column);
}

}  // namespace

std::vector<HeldOut> leaveOneOut(PointsRef points, const std::vector<Eigen::Index>& columns,
                                 const Observations& observations,
                                 const std::function<SightPlace(std::uint32_t, const Eigen::Vector3f&)>& placeOf) {
  std::vector<HeldOut> held_out;
  for (const Eigen::Index column : columns) {
    const Eigen::Vector3f point = points.col(column);
    const double lot = unitHash(point) / kHeldOutShare;
    if (lot >= 1) continue;
    const std::uint32_t first = observations.offsets[static_cast<std::size_t>(column)],
                        last = observations.offsets[static_cast<std::size_t>(column) + 1];
    if (last - first < kLeastViews) continue;
    const std::uint32_t left_out = first + static_cast<std::uint32_t>(lot * (last - first));
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(observations.values.rows());
    float weight = 0;
    for (std::uint32_t k = first; k < last; ++k) {
      if (k == left_out) continue;
      sum += observations.weights[k] * observations.values.col(k);
      weight += observations.weights[k];
    }
    if (!(weight > 0)) continue;
    const float error = (observations.values.col(left_out) - sum / weight).cwiseAbs().mean();
    const SightPlace sight = placeOf(observations.views[left_out], point);
    held_out.push_back({static_cast<std::uint8_t>(std::min(sight.camera, 255U)), cellAt(sight.place),
                        static_cast<std::uint8_t>(std::min(std::lround(error), 255L))});
  }
  return held_out;
}

std::vector<std::uint32_t> nearestObservations(const Observations& observations) {
  std::vector<std::uint32_t> nearest(observations.numPoints());
  for (std::size_t p = 0; p < nearest.size(); ++p) {
    const auto begin = observations.distances.begin();
    const auto first = begin + observations.offsets[p], last = begin + observations.offsets[p + 1];
    nearest[p] =
        static_cast<std::uint32_t>(first == last ? observations.numObservations()
                                                 : static_cast<std::size_t>(std::min_element(first, last) - begin));
  }
  return nearest;
}

}  // namespace cloud_colorizer
