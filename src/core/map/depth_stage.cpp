// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "map/fingerprint.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {

DepthImage renderDepth(Workspace& work, std::size_t view, const Eigen::Isometry3d& map_from_camera,
                       const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const DepthParams& params = work.params().depth;
  const Camera& camera = work.cameraOf(view);
  const ViewCone cone(camera, map_from_camera, params.max_view_distance);
  DepthSplatter splatter(camera, map_from_camera.inverse().cast<float>(), params,
                         work.emptySpace(view, map_from_camera));
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    if (!cone.mayShow(recording.tileBox(tile))) continue;
    throwIfCancelled(callbacks);
    const auto surface = work.surfaceSeenFrom(tile, view, map_from_camera.translation());
    splatter.add(surface->points, surface->surfels);
  }
  return splatter.finish();
}

void makeDepthImages(Workspace& work, const Callbacks& callbacks) {
  const DerivedFiles& files = work.files();
  files.claim(kDepthFolder, depthKey(work.recording(), work.params(), work.corrections()));
  const std::vector<std::size_t>& views = work.usableViews();
  const Callbacks turns = takingTurns(callbacks);
  ProgressMeter progress(turns, "depth images", views.size());
  parallelFor(work.params().colorize.num_threads, views.size(), [&](std::size_t k) {
    const std::size_t view = views[k];
    const bool todo = !files.hasDepth(view);
    if (todo) files.writeDepth(view, renderDepth(work, view, work.corrections()[view].map_from_camera, turns));
    progress.add(1, todo);
  });
}

}  // namespace cloud_colorizer
