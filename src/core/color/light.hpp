// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How what is seen of a glossy surface depends on the direction from which it is seen.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// What a point's views look at.
struct Sights {
  PointsRef points;
  const Eigen::Matrix3Xf& normals;  ///< unit, of any sign; zero: unknown
  const Observations& observations;
  const std::vector<Eigen::Vector3f>& eyes;  ///< m, camera centre of each view id

  /// Unit, from a point to the view of its observation k.
  Eigen::Vector3f toView(Eigen::Index point, std::uint32_t k) const {
    return (eyes[observations.views[k]] - points.col(point)).normalized();
  }
  /// Turned to the side from which the point is seen.
  Eigen::Vector3f facingNormal(Eigen::Index point) const;
  std::uint32_t begin(Eigen::Index point) const { return observations.offsets[static_cast<std::size_t>(point)]; }
  std::uint32_t end(Eigen::Index point) const { return observations.offsets[static_cast<std::size_t>(point) + 1]; }
};

/// The light that shows in a surface: with h half way between the directions to it and to the view, and the normal n,
/// its sheen is about exp(sharpness (n h - 1)), which is Blinn and Phong's (n h)^sharpness. Sharpness 0: there is none.
struct Light {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit, towards it
  float sharpness = 0;
};

/// The light that explains most of the differences between the views of each point, whose sheen has one strength
/// everywhere. Of some of the points; the same ones whatever the threads.
Light findLight(const Sights& sights);

/// What stands beside the colour of a point: functions of the direction to a view.
class AppearanceBasis {
 public:
  static constexpr int kLobes = 3, kMost = 8 + kLobes;
  using Functions = Eigen::Matrix<float, kMost, 1>;  ///< those that are not used are 0

  AppearanceBasis(Appearance appearance, const Light& light) : degree_(static_cast<int>(appearance)), light_(light) {}

  /// Real spherical harmonics of the degrees from 1 on of the direction r = 2 (n d) n - d, in which what is mirrored
  /// lies, and lobes about the light: as sharp as it is, and 2.5 times as broad and as sharp.
  Functions at(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_view) const;

 private:
  int degree_;
  Light light_;
};

}  // namespace cloud_colorizer
