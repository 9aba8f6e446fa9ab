// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/place_points.hpp"

namespace cloud_colorizer {
namespace {

struct RangeGate {
  explicit RangeGate(const RecordParams& params)
      : near_squared(params.min_range * params.min_range), far_squared(params.max_range * params.max_range) {}
  bool holds(double range_squared) const { return range_squared >= near_squared && range_squared <= far_squared; }

  double near_squared, far_squared;
};

}  // namespace

std::optional<Eigen::Vector3d> firstInRange(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                                            const RecordParams& params) {
  const RangeGate gate(params);
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    if (!gate.holds(cloud.positions.col(i).squaredNorm())) continue;
    const Eigen::Vector3d position = map_from_sensor * cloud.positions.col(i);
    if (position.allFinite()) return position;
  }
  return std::nullopt;
}

void placePoints(const Cloud& cloud, const Eigen::Isometry3d& relative_from_sensor, const RecordParams& params,
                 const TileGrid& grid, std::vector<PlacedPoint>& placed, Recorder::InsertCounts& counts) {
  const RangeGate gate(params);
  const Eigen::Matrix3d rotation = relative_from_sensor.linear();
  const Eigen::Vector3d translation = relative_from_sensor.translation();
  placed.clear();
  placed.reserve(static_cast<std::size_t>(cloud.positions.cols()));
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    const Eigen::Vector3d in_sensor = cloud.positions.col(i);
    const double range_squared = in_sensor.squaredNorm();
    if (!gate.holds(range_squared)) {
      ++(!in_sensor.allFinite()              ? counts.not_finite
         : range_squared < gate.near_squared ? counts.too_near
                                             : counts.too_far);
      continue;
    }
    const Eigen::Vector3d position = rotation * in_sensor + translation;
    if (!(position.cwiseAbs().maxCoeff() <= grid.limit())) {
      ++(in_sensor.allFinite() ? counts.too_far : counts.not_finite);
      continue;
    }
    PlacedPoint point;
    Eigen::Map<Eigen::Vector3f>(point.position.data()) = position.cast<float>();
    point.cell = grid.cellOf(point.position.data());
    point.source = static_cast<std::uint32_t>(i);
    placed.push_back(point);
  }
}

}  // namespace cloud_colorizer
