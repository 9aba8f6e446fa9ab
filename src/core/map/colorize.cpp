// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/colorize.hpp"

#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "map/colored_map.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

void requireColorable(const Recording& recording) {
  require(recording.numPoints() > 0, "recording ", recording.directory(),
          " has no points; was the cloud topic published, and is there tf from its frame to the map?");
  require(!recording.views().empty(), "recording ", recording.directory(),
          " has no views; were images and camera_info published, and is there tf from the camera to the map?");
}

}  // namespace

ColorizeSummary colorize(const Recording& recording, const Params& params, const Callbacks& callbacks) {
  StopWatch watch;
  params.check();
  requireColorable(recording);

  const FolderLock lock(recording.directory(), true);
  Workspace work(recording, params);
  if (params.colorize.memory_limit == 0 && callbacks.log) {
    const auto megabytes = static_cast<long>(work.memory().limit() / 1e6);
    callbacks.log(LogLevel::kInfo, "memory_limit: " + std::to_string(megabytes) + " MB");
  }
  checkImages(work, callbacks);      // per view: is its image whole
  findMoving(work, callbacks);       // per tile: what later and earlier scans saw through
  makeSurfels(work, callbacks);      // per tile: what closes the surface between the points
  alignViews(work, callbacks);       // all views: exposure and small corrections of the poses
  makeDepthImages(work, callbacks);  // per view: what it can see of the whole map
  colorChunks(work, callbacks);      // per chunk: observe, graph, system, solve; eq. (1)-(5)

  ColorizeSummary summary = summarize(work);
  summary.seconds = watch.lap();
  return summary;
}

}  // namespace cloud_colorizer
