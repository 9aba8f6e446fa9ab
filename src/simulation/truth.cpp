// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/truth.hpp"

#include <cmath>

#include "alignment/motion.hpp"
#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kOffset = 0.005;  // m before the surface, so that it does not hide itself

bool isSameFace(const Hit& a, const Hit& b) {
  return a.solid == b.solid && a.local.face == b.local.face;
}

/// Whether a small move of the point would put it on another face.
bool isNearEdge(const Scene& scene, const Eigen::Vector3d& point, const Hit& surface, const TruthOptions& options) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d moved = point + sign * options.edge_distance * Eigen::Vector3d::Unit(axis);
      const auto other = scene.closestPoint(moved, options.surface_distance + options.edge_distance);
      if (other && !isSameFace(*other, surface)) return true;
    }
  }
  return false;
}

PointTruth truthOf(const Scene& scene, const Eigen::Vector3d& point, const std::vector<TrueView>& views,
                   const TruthOptions& options) {
  PointTruth truth;
  const auto surface = scene.closestPoint(point, options.surface_distance);
  if (!surface) return truth;
  truth.truth = Truth::kOutOfView;
  truth.surface_distance = static_cast<float>(surface->distance);
  truth.color = scene.trueColor(*surface);
  truth.is_near_edge = isNearEdge(scene, point, *surface, options);
  for (const TrueView& view : views) {
    const LineOfSight sight = lineOfSight(scene, *surface, view, options.max_view_distance);
    if (sight == LineOfSight::kOutOfView) continue;
    if (truth.truth == Truth::kOutOfView) truth.truth = Truth::kHidden;
    if (sight == LineOfSight::kBlocked) continue;
    truth.truth = Truth::kVisible;
    ++truth.num_visible;
  }
  return truth;
}

}  // namespace

LineOfSight lineOfSight(const Scene& scene, const Hit& surface, const TrueView& view, double max_distance) {
  const Eigen::Vector3d eye = view.map_from_camera.translation(), way = surface.point - eye;
  if (way.squaredNorm() > max_distance * max_distance) return LineOfSight::kOutOfView;
  const Eigen::Vector3d in_camera = view.map_from_camera.linear().transpose() * way;
  if (!view.camera.project(in_camera.cast<float>())) return LineOfSight::kOutOfView;
  const Eigen::Vector3d before = surface.point + kOffset * surface.normal;
  const bool blocked = surface.normal.dot(way) >= 0 || scene.isBlocked(before, eye, view.time);
  return blocked ? LineOfSight::kBlocked : LineOfSight::kFree;
}

TrueView trueView(const Drive& drive, int camera, int frame) {
  const Twist motion =
      alignment::twistOf(drive.mapFromCamera(camera, frame, 0).inverse() * drive.mapFromCamera(camera, frame, 1));
  return {drive.cameras().at(static_cast<std::size_t>(camera)).camera.whileMoving(motion),
          drive.mapFromCamera(camera, frame), drive.imageTime(camera, frame)};
}

TrueView trueViewOfStamp(const Drive& drive, int camera, double image_stamp) {
  require<std::invalid_argument>(camera >= 0 && camera < drive.options().cameras, "camera ", camera,
                                 " is not one of the drive's ", drive.options().cameras);
  const double first = static_cast<double>(drive.imageStamp(camera, 0)) * 1e-9;
  const long frame = std::lround((image_stamp - first) * drive.options().rate);
  const double nearest = first + static_cast<double>(frame) / drive.options().rate;
  require<std::invalid_argument>(frame >= 0 && frame < drive.options().frames && std::abs(nearest - image_stamp) < 1e-3,
                                 std::to_string(image_stamp), " is no stamp of an image of camera_", camera,
                                 " of the drive");
  return trueView(drive, camera, static_cast<int>(frame));
}

std::vector<PointTruth> trueVisibility(const Scene& scene, const Eigen::Matrix3Xd& points,
                                       const std::vector<TrueView>& views, const TruthOptions& options) {
  constexpr Eigen::Index kBatch = 1024;
  std::vector<PointTruth> truths(static_cast<std::size_t>(points.cols()));
  const Eigen::Index num_batches = (points.cols() + kBatch - 1) / kBatch;
  parallelFor(options.num_threads, static_cast<std::size_t>(num_batches), [&](std::size_t batch) {
    const Eigen::Index begin = static_cast<Eigen::Index>(batch) * kBatch;
    for (Eigen::Index i = begin; i < std::min(points.cols(), begin + kBatch); ++i) {
      truths[static_cast<std::size_t>(i)] = truthOf(scene, points.col(i), views, options);
    }
  });
  return truths;
}

}  // namespace cloud_colorizer::simulation
