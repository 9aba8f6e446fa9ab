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
  const ViewCone cone(camera, map_from_camera, params.reach());
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

namespace {

std::vector<double> depthUnits(const Workspace& work) {
  return std::vector<double>(work.usableViews().size(), 1.0);
}

UnitFiles depthFiles(const Workspace& work) {
  UnitFiles files;
  for (const std::size_t view : work.usableViews()) files.push_back({DerivedFiles::nameOfView(view)});
  return files;
}

void makeDepthImages(Workspace& work, UnitRange units, const Callbacks& callbacks) {
  const DerivedFiles& files = work.files();
  const Callbacks turns = takingTurns(callbacks);
  ProgressMeter progress(turns, "depth images", units.size());
  parallelFor(work.params().colorize.num_threads, units.size(), [&](std::size_t k) {
    const std::size_t view = work.usableViews()[units.first + k];
    const bool todo = !files.hasDepth(view);
    if (todo) files.writeDepth(view, renderDepth(work, view, work.corrections()[view].map_from_camera, turns));
    progress.add(1, todo);
  });
}

}  // namespace

Stage depthStage() {
  return {"depth",
          "views",
          kDepthFolder,
          {"images", "moving", "surfels", "alignment"},
          depthUnits,
          [](const Workspace& work) { return depthKey(work.recording(), work.params(), work.corrections()); },
          depthFiles,
          makeDepthImages,
          {}};
}

}  // namespace cloud_colorizer
