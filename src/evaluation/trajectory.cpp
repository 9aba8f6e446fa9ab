// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory.hpp"

#include <cmath>

#include "alignment/priors.hpp"

namespace cloud_colorizer {
namespace {

/// The nearest view in time of the same camera before (or at) the stamp, or after it; views.size() when there is none.
std::size_t neighbor(const View& view, const std::vector<View>& views, bool before) {
  std::size_t nearest = views.size();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double gap = views[v].stamp - view.stamp;
    if (views[v].camera != view.camera || (gap <= 0) != before || std::abs(gap) > alignment::kMaxStampGap) continue;
    if (nearest == views.size() || std::abs(gap) < std::abs(views[nearest].stamp - view.stamp)) nearest = v;
  }
  return nearest;
}

/// In the camera's frame.
Eigen::Isometry3d correction(const View& view, const Eigen::Isometry3d& corrected) {
  return view.map_from_camera.inverse() * corrected;
}

/// The mean of the views' motions in the map, taken at the mean of their centres.
Eigen::Isometry3d commonMotion(const std::vector<View>& views, const std::vector<Eigen::Isometry3d>& corrected) {
  if (views.empty()) return Eigen::Isometry3d::Identity();
  const auto count = static_cast<double>(views.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const View& view : views) centre += view.map_from_camera.translation() / count;
  Twist mean = Twist::Zero();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Eigen::Isometry3d moved = corrected[v] * views[v].map_from_camera.inverse();
    mean += alignment::twistOf(Eigen::Translation3d(-centre) * moved * Eigen::Translation3d(centre)) / count;
  }
  return Eigen::Translation3d(centre) * alignment::motion(mean) * Eigen::Translation3d(-centre);
}

}  // namespace

Eigen::Isometry3d poseOnTrajectory(const View& view, const std::vector<View>& views,
                                   const std::vector<Eigen::Isometry3d>& corrected) {
  std::size_t before = neighbor(view, views, true), after = neighbor(view, views, false);
  if (before == views.size()) before = after;
  if (after == views.size()) after = before;
  if (before == views.size()) return commonMotion(views, corrected) * view.map_from_camera;
  const Eigen::Isometry3d a = correction(views[before], corrected[before]);
  const Eigen::Isometry3d b = correction(views[after], corrected[after]);
  const double span = views[after].stamp - views[before].stamp;
  const double share = span > 0 ? (view.stamp - views[before].stamp) / span : 0;
  Eigen::Isometry3d between = Eigen::Isometry3d::Identity();
  between.linear() = Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix();
  between.translation() = (1 - share) * a.translation() + share * b.translation();
  return view.map_from_camera * between;
}

}  // namespace cloud_colorizer
