// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tracks: which view sees which sample point, by view and by point.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "alignment/motion.hpp"
#include "cloud_colorizer/alignment/align.hpp"
#include "surface/point_runs.hpp"

namespace cloud_colorizer::alignment {

/// One view's sight of one point.
struct Sight {
  std::uint32_t point = 0;
  float weight = 1;         ///< cosine of the incidence
  float edge_distance = 0;  ///< px to the guard band of the nearest depth edge or the image border
};

/// Observation k of view v: offsets[v] <= k < offsets[v + 1], by ascending point. The observations of point p are
/// by_point[point_offsets[p]] ... by_point[point_offsets[p + 1] - 1], by ascending view.
struct Tracks {
  std::vector<std::uint32_t> offsets, views;
  std::vector<Sight> sights;
  std::vector<std::uint32_t> point_offsets, by_point;

  std::size_t numViews() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  std::size_t numPoints() const { return point_offsets.empty() ? 0 : point_offsets.size() - 1; }
  std::size_t numObservations() const { return sights.size(); }
};

/// A number for every observation; weight 0 where there is none.
struct SightValues {
  std::vector<float> values, weights;
};

/// The sample points that a view at a pose sees clearly, ascending: at most `max_points`, the same choice of points in
/// all views. `runs` are those of input.points.
std::vector<Sight> findSights(const AlignmentInput& input, const std::vector<PointRun>& runs, std::size_t view,
                              const Eigen::Isometry3d& map_from_camera, std::size_t max_points);

/// Calls visit(k, local, projected) for every `stride`-th observation of a view that is in the image at a state,
/// `margin` px from an edge: `local` is the point in the camera's frame, `projected` what Camera::linearize() makes of
/// it.
template <class Visit>
void forEachSight(const AlignmentInput& input, const Tracks& tracks, const PoseState& state, std::size_t view,
                  double margin, Visit&& visit, std::size_t stride = 1) {
  const Eigen::Isometry3d camera_from_map = correctedPose(input.views[view], state.views[view]).inverse();
  const Camera camera = input.cameraOf(view);
  for (std::size_t k = tracks.offsets[view]; k < tracks.offsets[view + 1]; k += stride) {
    if (tracks.sights[k].edge_distance < margin) continue;
    const Eigen::Vector3d local = camera_from_map * input.points.col(tracks.sights[k].point).cast<double>();
    if (const auto projected = camera.linearize(local)) visit(k, local, *projected);
  }
}

/// Of at most `max_points` of each view, chosen as in findSights, and of those only the points that `keep` tells;
/// empty: all.
Tracks makeTracks(const std::vector<std::vector<Sight>>& by_view, std::size_t num_points, std::size_t max_points,
                  const std::function<bool(std::uint32_t)>& keep = {});

/// The points of both, with the smaller distance to an edge.
std::vector<Sight> seenInBoth(const std::vector<Sight>& a, const std::vector<Sight>& b);

}  // namespace cloud_colorizer::alignment
