// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "map/fingerprint.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

/// A van that drove ahead left a trail of points that hides the street. Where a camera has been, nothing stays: points
/// there are of something that moved, and hide nothing.
void clearPath(const Recording& recording, std::size_t tile, double clear_radius, PointsRef points, Surfels& surfels) {
  const auto radius = static_cast<float>(clear_radius);
  std::vector<Eigen::Vector3f> places;
  for (const View& view : recording.views()) {
    const Eigen::Vector3f place = view.map_from_camera.translation().cast<float>();
    if (recording.tileBox(tile).exteriorDistance(place) < radius) places.push_back(place);
  }
  for (Eigen::Index i = 0; i < points.cols() && !places.empty(); ++i) {
    const auto isNear = [&](const Eigen::Vector3f& p) { return (p - points.col(i)).squaredNorm() < radius * radius; };
    if (std::any_of(places.begin(), places.end(), isNear)) surfels.radii[i] = -1;
  }
}

}  // namespace

void makeSurfels(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const DerivedFiles& files = work.files();
  files.claim(kSurfelsFolder, surfelsKey(recording, work.params()));
  ProgressMeter progress(callbacks, "surfels", recording.numPoints());
  parallelFor(work.params().colorize.num_threads, recording.tiles().size(), [&](std::size_t tile) {
    const bool todo = !files.hasSurfels(tile);
    if (todo) {
      const Points points = recording.readPoints(tile);
      Surfels surfels = estimateSurfels(points, work.params().surfels);
      clearPath(recording, tile, work.params().depth.clear_radius, points, surfels);
      files.writeSurfels(tile, surfels);
    }
    progress.add(recording.tiles()[tile].num_points, todo);
  });
}

}  // namespace cloud_colorizer
